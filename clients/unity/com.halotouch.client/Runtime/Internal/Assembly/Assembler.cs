using System.Collections.Generic;

namespace HaloTouch.Internal
{
    // Datagrams in, events out: the receiving half of a client. It has no I/O and no clock: the
    // caller passes bytes and the time in seconds on a monotonic clock. State is separate for each
    // (node, surface, session), and bounded.
    sealed class Assembler
    {
        const double TimeoutS = 3.0; // silence after which a service is lost
        const double SupersededS = 0.5; // the same for fingers of a session with a newer one
        const int MaxStreams = 64;

        readonly DatagramReader _reader = new DatagramReader();
        readonly Datagram _datagram = new Datagram();
        readonly List<Stream> _streams = new List<Stream>(); // in order of their creation
        readonly List<Ranked> _ranks = new List<Ranked>();
        readonly List<Pair> _collisions = new List<Pair>();
        readonly EventQueue _found = new EventQueue();
        int _droppedBefore;

        struct Ranked
        {
            public Key Key;
            public int Rank;
        }

        struct Pair
        {
            public Key Older;
            public string Newer;
        }

        public bool SawOtherMajor => _reader.SawOtherMajor;

        // Parts of frames that were old, came twice or contradicted their frame.
        public int Dropped
        {
            get
            {
                var dropped = _droppedBefore;
                for (var i = 0; i < _streams.Count; i++) dropped += _streams[i].Dropped;
                return dropped;
            }
        }

        // Adds the events of a datagram, after those of sessions that have expired. Null, or why it
        // is refused: nothing has changed then.
        public string Receive(byte[] bytes, int length, double nowS, EventQueue events)
        {
            var error = _reader.Read(bytes, length, _datagram);
            if (error != null) return error;
            Expire(nowS, events);
            for (var i = 0; i < _datagram.Items.Count; i++)
            {
                var item = _datagram.Items.Items[i];
                if (item.Kind == ItemKind.Part) ReceivePart(item.Part, nowS, events);
                else events.AddReport(item);
            }
            return null;
        }

        // Closes sessions that were silent for too long; to be called a few times a second.
        public void Expire(double nowS, EventQueue events)
        {
            for (var i = 0; i < _streams.Count; i++)
                _streams[i].IsSuperseded = Newest(_streams[i]) != _streams[i];
            for (var i = 0; i < _streams.Count;)
            {
                var stream = _streams[i];
                var superseded = stream.IsSuperseded && stream.HoldsPointers;
                if (nowS - stream.ReceivedS > (superseded ? SupersededS : TimeoutS))
                    CloseAt(i, events);
                else i++;
            }
        }

        // Ends a session now: its open touches end, and it is reported as lost.
        public void Close(in Key key, EventQueue events)
        {
            var index = IndexOf(in key);
            if (index >= 0) CloseAt(index, events);
        }

        void ReceivePart(Part part, double nowS, EventQueue events)
        {
            var key = new Key(part.Header.Node, part.Surface, part.Header.Session);
            var index = IndexOf(in key);
            var stream = index >= 0 ? _streams[index] : Open(part, in key, nowS, events);
            // A collision is reported before the frames that prove it.
            _found.Clear();
            if (stream.Receive(part, nowS, _found) == 0) return;
            AddCollision(stream, nowS, events);
            for (var i = 0; i < _found.Count; i++) events.AddFrame(_found[i].Frame);
        }

        Stream Open(Part part, in Key key, double nowS, EventQueue events)
        {
            if (_streams.Count >= MaxStreams) CloseAt(QuietestIndex(), events);
            var stream = new Stream(part, in key, RankOf(in key), nowS);
            _streams.Add(stream);
            ForgetClosedRanks();
            return stream;
        }

        void CloseAt(int index, EventQueue events)
        {
            var stream = _streams[index];
            _streams.RemoveAt(index);
            _droppedBefore += stream.Dropped;
            for (var i = _collisions.Count - 1; i >= 0; i--)
            {
                var pair = _collisions[i];
                var session = stream.Key.Session;
                var has = pair.Older.Session == session || pair.Newer == session;
                if (has && Key.SamePlace(in pair.Older, in stream.Key)) _collisions.RemoveAt(i);
            }
            stream.Close(events);
        }

        int IndexOf(in Key key)
        {
            for (var i = 0; i < _streams.Count; i++)
                if (Key.Same(in _streams[i].Key, in key)) return i;
            return -1;
        }

        int QuietestIndex()
        {
            var quietest = 0;
            for (var i = 1; i < _streams.Count; i++)
                if (_streams[i].ReceivedS < _streams[quietest].ReceivedS) quietest = i;
            return quietest;
        }

        // The session of the same node and surface that started last.
        Stream Newest(Stream stream)
        {
            var newest = stream;
            for (var i = 0; i < _streams.Count; i++)
                if (_streams[i].Rank > newest.Rank && Key.SamePlace(in _streams[i].Key, in stream.Key))
                    newest = _streams[i];
            return newest;
        }

        // A session that comes back keeps its number.
        int RankOf(in Key key)
        {
            var rank = 1;
            for (var i = 0; i < _ranks.Count; i++)
                if (_ranks[i].Rank >= rank) rank = _ranks[i].Rank + 1;
            for (var i = 0; i < _ranks.Count; i++)
            {
                var before = _ranks[i];
                if (!Key.Same(in before.Key, in key)) continue;
                rank = before.Rank;
                _ranks.RemoveAt(i);
                break;
            }
            _ranks.Add(new Ranked { Key = key, Rank = rank });
            return rank;
        }

        void ForgetClosedRanks()
        {
            var surplus = _ranks.Count - _streams.Count - MaxStreams;
            for (var i = 0; i < _ranks.Count && surplus > 0;)
            {
                var ranked = _ranks[i];
                if (IndexOf(in ranked.Key) >= 0)
                {
                    i++;
                    continue;
                }
                _ranks.RemoveAt(i);
                surplus--;
            }
        }

        // An older session that still sends frames well after a newer one began.
        void AddCollision(Stream stream, double nowS, EventQueue events)
        {
            var newest = Newest(stream);
            if (newest == stream || nowS - newest.FirstS <= SupersededS) return;
            for (var i = 0; i < _collisions.Count; i++)
            {
                var pair = _collisions[i];
                if (Key.Same(in pair.Older, in stream.Key) && pair.Newer == newest.Key.Session) return;
            }
            _collisions.Add(new Pair { Older = stream.Key, Newer = newest.Key.Session });
            events.AddCollision(in stream.Key, newest.Key.Session);
        }
    }
}
