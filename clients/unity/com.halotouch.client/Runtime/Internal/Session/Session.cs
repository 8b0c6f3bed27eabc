using System.Collections.Generic;

namespace HaloTouch.Internal
{
    interface ISessionListener
    {
        // The event is valid during the call only.
        void OnEvent(SessionEvent found);
    }

    // Events of the service that is followed. Pure: datagrams and times are arguments.
    sealed class Session
    {
        const int MaxRetired = 64; // replaced sessions, so that a running one is not followed again

        readonly Follow _follow;
        readonly ISessionListener _listener;
        readonly Assembler _assembler = new Assembler();
        readonly EventQueue _events = new EventQueue();
        readonly EventQueue _ended = new EventQueue();
        readonly List<Key> _retired = new List<Key>();
        Key _current;

        public Session(in Follow follow, ISessionListener listener)
        {
            _follow = follow;
            _listener = listener;
        }

        public readonly KnownReports Known = new KnownReports();

        // Whether a session is followed now.
        public bool IsFollowing { get; private set; }

        // Its node, surface and session.
        public Key Current => _current;

        public int Missed { get; private set; } // frames that never arrived
        public int Incomplete { get; private set; } // frames with a lost part
        public int Bad { get; private set; } // datagrams that could not be read
        public int Foreign { get; private set; } // datagrams of another major version
        public int Collisions { get; private set; } // pairs of services with one name
        public int Dropped => _assembler.Dropped; // parts that came late or twice
        public string LastError { get; private set; } = ""; // of the last bad datagram

        public void Receive(byte[] bytes, int length, double nowS)
        {
            _events.Clear();
            var error = _assembler.Receive(bytes, length, nowS, _events);
            if (error != null)
            {
                Bad++;
                LastError = error;
                _assembler.Expire(nowS, _events);
            }
            else if (_assembler.SawOtherMajor) Foreign++;
            Process();
        }

        // Only looks for lost services; to be called a few times a second.
        public void Expire(double nowS)
        {
            _events.Clear();
            _assembler.Expire(nowS, _events);
            Process();
        }

        void Process()
        {
            for (var i = 0; i < _events.Count; i++) Count(_events[i]);
            for (var i = 0; i < _events.Count; i++) Process(_events[i]);
        }

        void Count(SessionEvent found)
        {
            if (found.Kind == EventKind.Collision) Collisions++;
            if (found.Kind != EventKind.Frame) return;
            Missed += found.Frame.Missed;
            if (!found.Frame.IsComplete) Incomplete++;
        }

        void Process(SessionEvent found)
        {
            if (found.Kind == EventKind.Frame && Replaces(found)) Restart();
            if (found.Kind == EventKind.Lost) Known.Forget(found.Node, found.Surface, found.Session);
            if (!Accepts(found)) return;
            if (found.Kind == EventKind.Report) Known.Update(found);
            _listener.OnEvent(found);
        }

        // Whether a frame is of a newer session of the service that is followed.
        bool Replaces(SessionEvent frame) =>
            IsFollowing && !_follow.Everything && !frame.IsOf(in _current) && IsSamePlace(frame) &&
            !IsRetired(frame);

        void Restart()
        {
            _ended.Clear();
            _assembler.Close(in _current, _ended);
            for (var i = 0; i < _ended.Count; i++)
            {
                if (_ended[i].Kind == EventKind.Lost)
                    Known.Forget(_current.Node, _current.Surface, _current.Session);
                _listener.OnEvent(_ended[i]);
            }
            if (_retired.Count == MaxRetired) _retired.RemoveAt(0);
            _retired.Add(_current);
            IsFollowing = false;
        }

        bool Accepts(SessionEvent found)
        {
            var matches = _follow.Matches(found.Node, found.Surface);
            if (_follow.Everything) return matches;
            if (found.Kind == EventKind.Lost) return AcceptsLoss(found);
            if (found.Kind == EventKind.Collision) return IsFollowing ? IsSamePlace(found) : matches;
            // A report of another session is of a service with the same name: it moves no picture.
            if (found.Kind == EventKind.Report)
                return IsFollowing ? found.IsOf(in _current) : matches;
            if (!IsFollowing && matches && !IsRetired(found))
            {
                _current = new Key(found.Node, found.Surface, found.Session);
                IsFollowing = true;
            }
            return IsFollowing && found.IsOf(in _current);
        }

        bool AcceptsLoss(SessionEvent lost)
        {
            var followed = IsFollowing && lost.IsOf(in _current);
            if (followed) IsFollowing = false;
            for (var i = _retired.Count - 1; i >= 0; i--)
            {
                var retired = _retired[i];
                if (lost.IsOf(in retired)) _retired.RemoveAt(i);
            }
            return followed;
        }

        bool IsSamePlace(SessionEvent found) =>
            found.Node == _current.Node && found.Surface == _current.Surface;

        bool IsRetired(SessionEvent found)
        {
            for (var i = 0; i < _retired.Count; i++)
            {
                var retired = _retired[i];
                if (found.IsOf(in retired)) return true;
            }
            return false;
        }
    }
}
