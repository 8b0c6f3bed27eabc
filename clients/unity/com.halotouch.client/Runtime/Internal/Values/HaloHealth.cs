namespace HaloTouch
{
    /// <summary>State of the service over the last second.</summary>
    public readonly struct HaloHealth
    {
        /// <summary>Name of the service.</summary>
        public string Node { get; }

        /// <summary>Name of this run of the service.</summary>
        public string Session { get; }

        /// <summary>Processed frames per second.</summary>
        public float Fps { get; }

        /// <summary>Median time in ms from frame received to packet sent; -1 if unknown.</summary>
        public float LatencyMs { get; }

        /// <summary>Camera frames that were not processed, in this session.</summary>
        public int Drops { get; }

        /// <summary>Invalid frames, in this session.</summary>
        public int BadFrames { get; }

        /// <summary>What the hand tracker is doing.</summary>
        public HaloTracker Tracker { get; }

        /// <summary>What the camera is doing.</summary>
        public HaloCamera Camera { get; }

        /// <summary>Median age in ms of the hand tracker's result at a frame; -1 if unknown.</summary>
        public float TrackerMs { get; }

        /// <summary>How often the host's clock was set, in this session.</summary>
        public int ClockJumps { get; }

        /// <summary>Host's Unix time minus the time in frames, in ms.</summary>
        public float ClockErrorMs { get; }

        /// <summary>Whether the calibration still fits.</summary>
        public HaloProfileFit ProfileFit { get; }

        /// <summary>Routers and peers of Zenoh to which there is no connection now.</summary>
        public int ZenohMissing { get; }

        /// <summary>Profiles that could not be written, in this session.</summary>
        public int WriteErrors { get; }

        /// <summary>Memory of the service's process in MB; -1 if unknown.</summary>
        public int MemoryMb { get; }

        /// <summary>How much work is left out because the machine is busy.</summary>
        public HaloLoad Load { get; }

        /// <summary>Images per second at which the hand model looked; -1 if unknown.</summary>
        public float LooksHz { get; }

        /// <summary>When it was sent, Unix time in whole seconds; 0 if unknown.</summary>
        public int TimeS { get; }

        /// <summary>Microseconds within the second.</summary>
        public int TimeFracUs { get; }

        /// <summary>Surfaces of other services that a canvas merges now; 0 if it is none.</summary>
        public int Nodes { get; }

        /// <summary>Of a canvas: the largest difference of a node's clock from its own.</summary>
        public float ClockOffsetMs { get; }

        /// <summary>Standard deviation of that; -1 if unknown.</summary>
        public float ClockDeviationMs { get; }

        internal HaloHealth(
            string node, string session, float fps, float latencyMs, int drops, int badFrames,
            HaloTracker tracker, HaloCamera camera, float trackerMs, int clockJumps,
            float clockErrorMs, HaloProfileFit profileFit, int zenohMissing, int writeErrors,
            int memoryMb, HaloLoad load, float looksHz, int timeS, int timeFracUs,
            int nodes, float clockOffsetMs, float clockDeviationMs)
        {
            Node = node;
            Session = session;
            Fps = fps;
            LatencyMs = latencyMs;
            Drops = drops;
            BadFrames = badFrames;
            Tracker = tracker;
            Camera = camera;
            TrackerMs = trackerMs;
            ClockJumps = clockJumps;
            ClockErrorMs = clockErrorMs;
            ProfileFit = profileFit;
            ZenohMissing = zenohMissing;
            WriteErrors = writeErrors;
            MemoryMb = memoryMb;
            Load = load;
            LooksHz = looksHz;
            TimeS = timeS;
            TimeFracUs = timeFracUs;
            Nodes = nodes;
            ClockOffsetMs = clockOffsetMs;
            ClockDeviationMs = clockDeviationMs;
        }
    }
}
