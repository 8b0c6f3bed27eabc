using HaloTouch.Internal;

namespace HaloTouch
{
    /// <summary>
    /// The complete state of one surface at one moment. The object is used again for the next frame:
    /// copy what you need later.
    /// </summary>
    public sealed class HaloFrame
    {
        internal readonly Growing<HaloPointer> PointerItems = new Growing<HaloPointer>(10);
        internal readonly Growing<HaloContact> ContactItems = new Growing<HaloContact>(8);

        /// <summary>Name of the service.</summary>
        public string Node { get; internal set; } = "";

        /// <summary>Name of the surface.</summary>
        public string Surface { get; internal set; } = "";

        /// <summary>Name of this run of the service.</summary>
        public string Session { get; internal set; } = "";

        /// <summary>Number of the frame: grows by 1, modulo 2^24.</summary>
        public int Number { get; internal set; }

        /// <summary>Time in microseconds: Unix time when live, the file's own time in a recording.</summary>
        public long TimeUs { get; internal set; }

        /// <summary>Milliseconds since the first frame of the session, modulo 2^24.</summary>
        public int SessionMs { get; internal set; }

        /// <summary>Frames that were lost before this one.</summary>
        public int Missed { get; internal set; }

        /// <summary>False if a part of the frame was lost: its fingers stay as before.</summary>
        public bool IsComplete { get; internal set; } = true;

        /// <summary>The fingers.</summary>
        public HaloList<HaloPointer> Pointers => new HaloList<HaloPointer>(PointerItems);

        /// <summary>Touches that began or ended, those of one finger in order of time.</summary>
        public HaloList<HaloContact> Contacts => new HaloList<HaloContact>(ContactItems);

        /// <summary>Finds a finger by its id; false if it is not in this frame.</summary>
        public bool TryGetPointer(int id, out HaloPointer pointer)
        {
            for (var i = 0; i < PointerItems.Count; i++)
            {
                if (PointerItems.Items[i].Id != id) continue;
                pointer = PointerItems.Items[i];
                return true;
            }
            pointer = default(HaloPointer);
            return false;
        }

        /// <summary>Whether a finger goes on with a touch that began in an earlier frame.</summary>
        public bool IsMoving(HaloPointer pointer)
        {
            if (!pointer.IsTouching) return false;
            for (var i = 0; i < ContactItems.Count; i++)
            {
                var contact = ContactItems.Items[i];
                if (contact.Id == pointer.Id && contact.Contacts == pointer.Contacts) return false;
            }
            return true;
        }

        internal void CopyFrom(HaloFrame other)
        {
            CopyHead(other);
            PointerItems.CopyFrom(other.PointerItems);
            ContactItems.CopyFrom(other.ContactItems);
        }

        internal void CopyHead(HaloFrame other)
        {
            Node = other.Node;
            Surface = other.Surface;
            Session = other.Session;
            Number = other.Number;
            TimeUs = other.TimeUs;
            SessionMs = other.SessionMs;
            Missed = other.Missed;
            IsComplete = other.IsComplete;
        }
    }
}
