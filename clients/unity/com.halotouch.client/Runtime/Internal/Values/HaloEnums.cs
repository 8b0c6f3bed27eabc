namespace HaloTouch
{
    /// <summary>Which hand a finger belongs to. A later version of the service can send other numbers.</summary>
    public enum HaloHand
    {
        /// <summary>Not known.</summary>
        Unknown,
        /// <summary>The left hand.</summary>
        Left,
        /// <summary>The right hand.</summary>
        Right,
    }

    /// <summary>Which finger it is.</summary>
    public enum HaloFinger
    {
        /// <summary>The thumb.</summary>
        Thumb,
        /// <summary>The index finger.</summary>
        Index,
        /// <summary>The middle finger.</summary>
        Middle,
        /// <summary>The ring finger.</summary>
        Ring,
        /// <summary>The little finger.</summary>
        Little,
    }

    /// <summary>Whether a finger is in the air or on the surface.</summary>
    public enum HaloState
    {
        /// <summary>In the air.</summary>
        Hover,
        /// <summary>On the surface.</summary>
        Touch,
    }

    /// <summary>How much of its calibration the service has.</summary>
    public enum HaloCalibration
    {
        /// <summary>Nothing: there are no fingers.</summary>
        None,
        /// <summary>Some steps are missing: fingers are less accurate than possible.</summary>
        Partial,
        /// <summary>Everything.</summary>
        Complete,
    }

    /// <summary>Where the fingers come from.</summary>
    public enum HaloSource
    {
        /// <summary>A camera.</summary>
        Camera,
        /// <summary>A recording.</summary>
        Recording,
        /// <summary>The virtual camera.</summary>
        Virtual,
    }

    /// <summary>What the service's hand tracker is doing.</summary>
    public enum HaloTracker
    {
        /// <summary>It is off.</summary>
        Off,
        /// <summary>It starts.</summary>
        Starting,
        /// <summary>It runs and finds no hand.</summary>
        Searching,
        /// <summary>It follows hands.</summary>
        Tracking,
        /// <summary>It has failed.</summary>
        Failed,
    }

    /// <summary>What the service's camera is doing.</summary>
    public enum HaloCamera
    {
        /// <summary>It starts.</summary>
        Starting,
        /// <summary>It runs.</summary>
        Running,
        /// <summary>It is unplugged or silent; the service tries to open it again.</summary>
        Lost,
        /// <summary>A recording has reached its end.</summary>
        Ended,
    }

    /// <summary>What the service leaves out because the machine is busy.</summary>
    public enum HaloLoad
    {
        /// <summary>Nothing.</summary>
        None,
        /// <summary>The hand model gets at most ten images a second.</summary>
        Reduced,
        /// <summary>The hand model gets at most five images a second.</summary>
        Least,
        /// <summary>Likewise, and camera frames were left out in the last second.</summary>
        Dropping,
    }

    /// <summary>Whether the calibration still fits what the camera shows.</summary>
    public enum HaloProfileFit
    {
        /// <summary>No calibration, or not checked yet.</summary>
        Unknown,
        /// <summary>It fits.</summary>
        Good,
        /// <summary>The surface is nearer or farther than when it was calibrated.</summary>
        Moved,
        /// <summary>Camera or table is tilted.</summary>
        Tilted,
        /// <summary>Most of the calibrated background is not there.</summary>
        Hidden,
        /// <summary>The printed marker is at another place.</summary>
        Marker,
    }
}
