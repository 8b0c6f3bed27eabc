namespace HaloTouch.Internal
{
    // The header of a frame.
    readonly struct Header
    {
        public readonly string Node;
        public readonly string Session;
        public readonly int Frame;
        public readonly int TimeS;
        public readonly int TimeFracUs;
        public readonly int Count;
        public readonly int SessionMs;

        public Header(
            string node, string session, int frame, int timeS, int timeFracUs, int count,
            int sessionMs)
        {
            Node = node;
            Session = session;
            Frame = frame;
            TimeS = timeS;
            TimeFracUs = timeFracUs;
            Count = count;
            SessionMs = sessionMs;
        }

        public long TimeUs => TimeS * 1000000L + TimeFracUs;

        public static bool Same(in Header a, in Header b) =>
            a.Frame == b.Frame && a.TimeS == b.TimeS && a.TimeFracUs == b.TimeFracUs &&
            a.Count == b.Count && a.SessionMs == b.SessionMs && a.Node == b.Node &&
            a.Session == b.Session;
    }

    // The content of one datagram for one frame.
    sealed class Part
    {
        public string Surface;
        public Header Header;
        public readonly Growing<int> Ids = new Growing<int>(10); // of the whole frame
        public readonly Growing<HaloPointer> Pointers = new Growing<HaloPointer>(10);
        public readonly Growing<HaloContact> Contacts = new Growing<HaloContact>(8);

        public void Start(string surface, in Header header)
        {
            Surface = surface;
            Header = header;
            Ids.Clear();
            Pointers.Clear();
            Contacts.Clear();
        }

        public void CopyFrom(Part other)
        {
            Start(other.Surface, in other.Header);
            Ids.CopyFrom(other.Ids);
            Pointers.CopyFrom(other.Pointers);
            Contacts.CopyFrom(other.Contacts);
        }

        // Whether both can be parts of one frame.
        public bool AgreesWith(Part other)
        {
            if (!Header.Same(in Header, in other.Header) || Ids.Count != other.Ids.Count) return false;
            for (var i = 0; i < Ids.Count; i++)
                if (Ids.Items[i] != other.Ids.Items[i]) return false;
            return true;
        }

        public int FindPointer(int id)
        {
            for (var i = 0; i < Pointers.Count; i++)
                if (Pointers.Items[i].Id == id) return i;
            return -1;
        }

        public bool HasContact(in HaloContact contact)
        {
            for (var i = 0; i < Contacts.Count; i++)
                if (HaloContact.Same(in Contacts.Items[i], in contact)) return true;
            return false;
        }

        // Removes events of more than `agoMs` before the frame.
        public void RemoveContactsBefore(double agoMs)
        {
            for (var i = Contacts.Count - 1; i >= 0; i--)
                if (!(Contacts.Items[i].AgoMs <= agoMs)) Contacts.RemoveAt(i);
        }

        public bool IsAlive(int id)
        {
            for (var i = 0; i < Ids.Count; i++)
                if (Ids.Items[i] == id) return true;
            return false;
        }
    }
}
