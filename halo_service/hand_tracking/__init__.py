"""Where the hands are: MediaPipe on the camera's picture, beside the path of the frames.

Rule: a tracker is stateful and late, so it stands outside the sensing, which is handed what
it last saw. OpenMP and OpenCV have to be held to one thread each before this room is first
imported (environment variables), or the tracker starves the frames beside it.
"""
