namespace HaloTouch.Internal
{
    // The frames of one session on one surface. A frame is reported once, whole if all its parts
    // arrived, and never after a newer one.
    sealed class Stream
    {
        const int Modulus = 1 << 24;
        const int MaxContacts = 256;
        const double JoinMs = 200; // events so long before our first frame are late copies

        public readonly Key Key;
        public readonly double FirstS;
        public readonly int Rank; // sessions are numbered by first arrival

        readonly TouchCounter _touches = new TouchCounter();
        readonly Part _pending = new Part();
        readonly Growing<HaloContact> _news = new Growing<HaloContact>(8); // of a part to be merged
        HaloFrame _last = new HaloFrame();
        HaloFrame _spare = new HaloFrame();
        readonly long _joinedUs;
        bool _hasLast;
        bool _hasPending;
        bool _joining = true; // until a whole frame was reported

        public double ReceivedS { get; private set; }

        // Parts that were old, came twice or contradicted their frame.
        public int Dropped { get; private set; }

        // Set by the assembler: its node has a newer session on this surface.
        public bool IsSuperseded;

        public bool HoldsPointers => _hasLast && _last.PointerItems.Count > 0;

        public Stream(Part part, in Key key, int rank, double nowS)
        {
            _joinedUs = part.Header.TimeUs;
            Key = key;
            Rank = rank;
            FirstS = ReceivedS = nowS;
        }

        // Adds the frames that a part completes, or proves incomplete. Their number.
        public int Receive(Part part, double nowS, EventQueue events)
        {
            ReceivedS = nowS;
            part.RemoveContactsBefore((part.Header.TimeUs - _joinedUs) / 1000.0 + JoinMs);
            var number = part.Header.Frame;
            if (_hasLast && !IsNewer(number, _last.Number)) return ReceiveLate(part, events);
            var count = 0;
            if (!_hasPending) SetPending(part);
            else if (IsNewer(number, _pending.Header.Frame))
            {
                Report(false, events);
                count++;
                SetPending(part);
            }
            else if (!Merge(part))
            {
                Dropped++;
                return 0;
            }
            if (_pending.Pointers.Count != _pending.Header.Count) return count;
            Report(true, events);
            _hasPending = false;
            return count + 1;
        }

        // The last events of a lost session: no pointers, open touches ended.
        public void Close(EventQueue events)
        {
            _touches.Close();
            if (_hasLast && (_last.PointerItems.Count > 0 || _touches.Found.Count > 0))
            {
                var frame = events.AddFrame(_last).Frame;
                frame.PointerItems.Clear();
                frame.ContactItems.CopyFrom(_touches.Found);
                frame.Missed = 0;
                frame.IsComplete = true;
            }
            events.AddLost(in Key);
        }

        static int Ahead(int a, int b) => (a - b) & (Modulus - 1);

        static bool IsNewer(int a, int b) => Ahead(a, b) > 0 && Ahead(a, b) < Modulus / 2;

        void SetPending(Part part)
        {
            _pending.CopyFrom(part);
            _hasPending = true;
        }

        // Adds a part to the pending frame; false if it belongs to another one or adds nothing.
        bool Merge(Part part)
        {
            if (!part.AgreesWith(_pending)) return false;
            var isNew = false;
            for (var i = 0; i < part.Pointers.Count; i++)
                isNew |= _pending.FindPointer(part.Pointers.Items[i].Id) < 0;
            _news.Clear();
            for (var i = 0; i < part.Contacts.Count; i++)
                if (!_pending.HasContact(in part.Contacts.Items[i])) _news.Add(in part.Contacts.Items[i]);
            if (!isNew && _news.Count == 0 || _pending.Contacts.Count + _news.Count > MaxContacts)
                return false;
            for (var i = 0; i < _news.Count; i++) _pending.Contacts.Add(in _news.Items[i]);
            for (var i = 0; i < part.Pointers.Count; i++) AddPointer(in part.Pointers.Items[i]);
            return true;
        }

        void AddPointer(in HaloPointer pointer)
        {
            var index = _pending.FindPointer(pointer.Id);
            if (index < 0) _pending.Pointers.Add(in pointer);
            else _pending.Pointers.Items[index] = pointer;
        }

        // Late events of a frame that was already reported.
        int ReceiveLate(Part part, EventQueue events)
        {
            if (part.Header.Frame == _last.Number && part.Contacts.Count > 0)
            {
                _touches.Count(_last.PointerItems, part.Contacts, false, true);
                if (_touches.Found.Count > 0)
                {
                    var frame = events.AddFrame(_last).Frame;
                    frame.ContactItems.CopyFrom(_touches.Found);
                    frame.Missed = 0;
                    return 1;
                }
            }
            Dropped++;
            return 0;
        }

        void Report(bool complete, EventQueue events)
        {
            var next = _spare;
            Fill(next, complete);
            _touches.Count(next.PointerItems, _pending.Contacts, _joining, complete);
            next.ContactItems.CopyFrom(_touches.Found);
            _joining &= !complete;
            _spare = _last;
            _last = next;
            _hasLast = true;
            events.AddFrame(next);
        }

        void Fill(HaloFrame next, bool complete)
        {
            var header = _pending.Header;
            next.Node = Key.Node;
            next.Surface = Key.Surface;
            next.Session = Key.Session;
            next.Number = header.Frame;
            next.TimeUs = header.TimeUs;
            next.SessionMs = header.SessionMs;
            next.Missed = _hasLast ? Ahead(header.Frame, _last.Number) - 1 : 0;
            next.IsComplete = complete;
            next.PointerItems.Clear();
            for (var i = 0; i < _pending.Ids.Count; i++)
            {
                var id = _pending.Ids.Items[i];
                var index = _pending.FindPointer(id);
                if (index >= 0) next.PointerItems.Add(in _pending.Pointers.Items[index]);
                else if (_hasLast && _last.TryGetPointer(id, out var before))
                    next.PointerItems.Add(in before);
            }
        }
    }
}
