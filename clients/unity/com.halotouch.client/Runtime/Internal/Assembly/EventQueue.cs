namespace HaloTouch.Internal
{
    enum EventKind { Frame, Report, Lost, Collision }

    // What a datagram, or the silence after it, has caused.
    sealed class SessionEvent
    {
        public EventKind Kind;
        public string Node;
        public string Surface;
        public string Session;
        public string NewerSession; // of a collision
        public readonly HaloFrame Frame = new HaloFrame();
        public ItemKind ReportKind;
        public HaloScene Scene;
        public HaloHomography Homography;
        public HaloPose Pose;
        public HaloHealth Health;

        public bool IsOf(in Key key) =>
            Node == key.Node && Surface == key.Surface && Session == key.Session;
    }

    // Events in order. Used again for the next datagram, so that a frame allocates nothing.
    sealed class EventQueue
    {
        const int MaxReused = 32;

        readonly Growing<SessionEvent> _events = new Growing<SessionEvent>(4);
        int _count;

        public int Count => _count;

        public SessionEvent this[int index] => _events.Items[index];

        public void Clear()
        {
            while (_events.Count > MaxReused) _events.RemoveAt(_events.Count - 1);
            _count = 0;
        }

        public SessionEvent AddFrame(HaloFrame frame)
        {
            var added = Add(EventKind.Frame, frame.Node, frame.Surface, frame.Session);
            added.Frame.CopyFrom(frame);
            return added;
        }

        public void AddLost(in Key key)
        {
            Add(EventKind.Lost, key.Node, key.Surface, key.Session);
        }

        public void AddCollision(in Key older, string newer)
        {
            Add(EventKind.Collision, older.Node, older.Surface, older.Session).NewerSession = newer;
        }

        public void AddReport(Item item)
        {
            var added = Add(EventKind.Report, null, item.Surface, null);
            added.ReportKind = item.Kind;
            if (item.Kind == ItemKind.Scene)
            {
                added.Scene = item.Scene;
                added.Node = item.Scene.Node;
                added.Session = item.Scene.Session;
            }
            else if (item.Kind == ItemKind.Homography)
            {
                added.Homography = item.Homography;
                added.Node = item.Homography.Node;
                added.Session = item.Homography.Session;
            }
            else if (item.Kind == ItemKind.Pose)
            {
                added.Pose = item.Pose;
                added.Node = item.Pose.Node;
                added.Session = item.Pose.Session;
            }
            else
            {
                added.Health = item.Health;
                added.Node = item.Health.Node;
                added.Session = item.Health.Session;
            }
        }

        SessionEvent Add(EventKind kind, string node, string surface, string session)
        {
            if (_count == _events.Count) _events.Add(new SessionEvent());
            var added = _events.Items[_count++];
            added.Kind = kind;
            added.Node = node;
            added.Surface = surface;
            added.Session = session;
            return added;
        }
    }
}
