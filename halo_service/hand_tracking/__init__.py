"""Where the hands are: MediaPipe on the camera's image, in parallel with the frames.

Rule: a tracker is stateful and late, so it runs outside the sensing, which gets the hands that it
found last. OpenMP and OpenCV must be limited to one thread each before this package is first
imported (environment variables), or the tracker takes the cores from the frames.
"""
