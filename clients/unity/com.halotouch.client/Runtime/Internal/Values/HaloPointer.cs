namespace HaloTouch
{
    /// <summary>One fingertip above or on the surface, at the time of its frame.</summary>
    public readonly struct HaloPointer
    {
        /// <summary>Grows; a session uses each id for one finger only.</summary>
        public int Id { get; }

        /// <summary>The lowest free number, 0 to 9: for synthesizer voices and colours.</summary>
        public int Slot { get; }

        /// <summary>Which hand.</summary>
        public HaloHand Hand { get; }

        /// <summary>Which finger.</summary>
        public HaloFinger Finger { get; }

        /// <summary>Whether it hovers or touches.</summary>
        public HaloState State { get; }

        /// <summary>Position over the surface's width: 0 left, 1 right; not clamped.</summary>
        public float U { get; }

        /// <summary>Position over the surface's height: 0 far edge, 1 near edge; not clamped.</summary>
        public float V { get; }

        /// <summary>Position in mm from the surface's top left corner, to the right.</summary>
        public float XMm { get; }

        /// <summary>Position in mm from the surface's top left corner, towards the user.</summary>
        public float YMm { get; }

        /// <summary>Height of the fingertip above the surface in mm; 0 in touch.</summary>
        public float HoverMm { get; }

        /// <summary>0 in hover; in touch at least 0.02, 1 at the calibrated medium press, more beyond.</summary>
        public float Pressure { get; }

        /// <summary>Velocity on the surface in mm/s, to the right.</summary>
        public float VxMmS { get; }

        /// <summary>Velocity on the surface in mm/s, towards the user.</summary>
        public float VyMmS { get; }

        /// <summary>0 to 1.</summary>
        public float Confidence { get; }

        /// <summary>Number of touches that this finger has begun.</summary>
        public int Contacts { get; }

        /// <summary>Force in grams; -1 if it is unknown.</summary>
        public float ForceG { get; }

        /// <summary>Whether the finger is on the surface.</summary>
        public bool IsTouching => State == HaloState.Touch;

        internal HaloPointer(
            int id, int slot, HaloHand hand, HaloFinger finger, HaloState state, float u, float v,
            float xMm, float yMm, float hoverMm, float pressure, float vxMmS, float vyMmS,
            float confidence, int contacts, float forceG)
        {
            Id = id;
            Slot = slot;
            Hand = hand;
            Finger = finger;
            State = state;
            U = u;
            V = v;
            XMm = xMm;
            YMm = yMm;
            HoverMm = hoverMm;
            Pressure = pressure;
            VxMmS = vxMmS;
            VyMmS = vyMmS;
            Confidence = confidence;
            Contacts = contacts;
            ForceG = forceG;
        }
    }
}
