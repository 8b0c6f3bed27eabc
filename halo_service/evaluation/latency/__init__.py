"""How soon a frame's packet leaves: ours and the paper's order, on the same frames in one run.

Rule: the clock starts when the device has delivered a frame, before anything is decoded, and stops
when its last datagram is with the socket. Frames are simulated or read beforehand, so that this is
not counted, and come at the camera's rate.
"""
