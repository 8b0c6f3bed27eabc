namespace HaloTouch
{
    /// <summary>A touch that began or ended. Each is reported once.</summary>
    public readonly struct HaloContact
    {
        /// <summary>True if the touch ended, false if it began.</summary>
        public bool IsUp { get; }

        /// <summary>The finger's id.</summary>
        public int Id { get; }

        /// <summary>The finger's slot.</summary>
        public int Slot { get; }

        /// <summary>Position of the event over the surface's width.</summary>
        public float U { get; }

        /// <summary>Position of the event over the surface's height.</summary>
        public float V { get; }

        /// <summary>Speed in mm/s before contact; -1 if unknown, 0 for the end of a touch.</summary>
        public float StrikeMmS { get; }

        /// <summary>Time of the event in ms before the frame's time.</summary>
        public float AgoMs { get; }

        /// <summary>Number of this touch, counted by finger.</summary>
        public int Contacts { get; }

        internal HaloContact(
            bool isUp, int id, int slot, float u, float v, float strikeMmS, float agoMs, int contacts)
        {
            IsUp = isUp;
            Id = id;
            Slot = slot;
            U = u;
            V = v;
            StrikeMmS = strikeMmS;
            AgoMs = agoMs;
            Contacts = contacts;
        }

        internal static bool Same(in HaloContact a, in HaloContact b) =>
            a.IsUp == b.IsUp && a.Id == b.Id && a.Slot == b.Slot && a.U == b.U && a.V == b.V &&
            a.StrikeMmS == b.StrikeMmS && a.AgoMs == b.AgoMs && a.Contacts == b.Contacts;

        // A finger's touches by number, each begun before it ends.
        internal static bool IsAfter(in HaloContact a, in HaloContact b)
        {
            if (a.Id != b.Id) return a.Id > b.Id;
            if (a.Contacts != b.Contacts) return a.Contacts > b.Contacts;
            return a.IsUp && !b.IsUp;
        }
    }
}
