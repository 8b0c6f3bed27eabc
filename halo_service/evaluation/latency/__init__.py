"""How soon a frame's packet leaves: ours beside the paper's order, on the same frames in one run.

Rule: the clock starts when the device has handed a frame over, before anything is decoded, and
stops when its last datagram is with the socket. Frames are drawn or read beforehand, so that
nothing of it is counted, and come as often as in life.
"""
