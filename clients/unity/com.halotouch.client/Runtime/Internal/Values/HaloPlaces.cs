namespace HaloTouch
{
    /// <summary>Maps the surface (mm) to the pixels of a projector.</summary>
    public readonly struct HaloHomography
    {
        /// <summary>Name of the service.</summary>
        public string Node { get; }

        /// <summary>Name of this run of the service.</summary>
        public string Session { get; }

        /// <summary>The scene's revision that it belongs to.</summary>
        public int Revision { get; }

        /// <summary>Width of the projector's image in pixels.</summary>
        public int WidthPx { get; }

        /// <summary>Height of the projector's image in pixels.</summary>
        public int HeightPx { get; }

        /// <summary>Surface mm to projector pixels; (0, 0) is the outer corner of the top left one.</summary>
        public HaloMatrix33 ProjectorFromSurface { get; }

        internal HaloHomography(
            string node, string session, int revision, int widthPx, int heightPx,
            HaloMatrix33 projectorFromSurface)
        {
            Node = node;
            Session = session;
            Revision = revision;
            WidthPx = widthPx;
            HeightPx = heightPx;
            ProjectorFromSurface = projectorFromSurface;
        }
    }

    /// <summary>Poses of the depth camera and of a printed marker.</summary>
    public readonly struct HaloPose
    {
        /// <summary>Name of the service.</summary>
        public string Node { get; }

        /// <summary>Name of this run of the service.</summary>
        public string Session { get; }

        /// <summary>The scene's revision that it belongs to.</summary>
        public int Revision { get; }

        /// <summary>p_camera = M p_surface, mm.</summary>
        public HaloMatrix34 CameraFromSurface { get; }

        /// <summary>p_marker = M p_surface, mm: x to the marker's right, y to its bottom, z into it.</summary>
        public HaloMatrix34 AnchorFromSurface { get; }

        /// <summary>Whether <see cref="AnchorFromSurface"/> is known.</summary>
        public bool IsAnchored { get; }

        internal HaloPose(
            string node, string session, int revision, HaloMatrix34 cameraFromSurface,
            HaloMatrix34 anchorFromSurface, bool isAnchored)
        {
            Node = node;
            Session = session;
            Revision = revision;
            CameraFromSurface = cameraFromSurface;
            AnchorFromSurface = anchorFromSurface;
            IsAnchored = isAnchored;
        }
    }
}
