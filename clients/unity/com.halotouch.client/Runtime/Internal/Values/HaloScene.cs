namespace HaloTouch
{
    /// <summary>Properties of a surface and its service.</summary>
    public readonly struct HaloScene
    {
        /// <summary>Name of the service.</summary>
        public string Node { get; }

        /// <summary>Name of this run of the service.</summary>
        public string Session { get; }

        /// <summary>Version of the protocol, `major.minor.patch`.</summary>
        public string Version { get; }

        /// <summary>Width of the surface in mm, left to right.</summary>
        public float WidthMm { get; }

        /// <summary>Height of the surface in mm, far edge to near edge.</summary>
        public float HeightMm { get; }

        /// <summary>How much is calibrated.</summary>
        public HaloCalibration Calibration { get; }

        /// <summary>Number of changes of surface, homography and pose in this session.</summary>
        public int Revision { get; }

        /// <summary>Where the fingers come from.</summary>
        public HaloSource Source { get; }

        /// <summary>Nominal frames per second of the source; 0 if it has none.</summary>
        public float RateHz { get; }

        /// <summary>UDP port of the service for messages from clients; 0 if it has none.</summary>
        public int ControlPort { get; }

        /// <summary>Whether the service has found another one with its name.</summary>
        public bool Collision { get; }

        /// <summary>Unix time of the newest step of the calibration, s; 0 if unknown.</summary>
        public int CalibratedS { get; }

        /// <summary>Version of the program that sends; empty if unknown.</summary>
        public string ServiceVersion { get; }

        /// <summary>Version of its Zenoh; empty without Zenoh.</summary>
        public string ZenohVersion { get; }

        internal HaloScene(
            string node, string session, string version, float widthMm, float heightMm,
            HaloCalibration calibration, int revision, HaloSource source, float rateHz,
            int controlPort, bool collision, int calibratedS, string serviceVersion,
            string zenohVersion)
        {
            Node = node;
            Session = session;
            Version = version;
            WidthMm = widthMm;
            HeightMm = heightMm;
            Calibration = calibration;
            Revision = revision;
            Source = source;
            RateHz = rateHz;
            ControlPort = controlPort;
            Collision = collision;
            CalibratedS = calibratedS;
            ServiceVersion = serviceVersion;
            ZenohVersion = zenohVersion;
        }
    }
}
