namespace HaloTouch.Internal
{
    // Counts each touch once: repeated events are reported once, lost ones are inferred from the
    // pointers, which carry the number of touches that they have begun.
    sealed class TouchCounter
    {
        const float UnknownStrike = -1;
        const int MaxRemembered = 256; // fingers that left and may still have repeated events

        struct Finger
        {
            public int Id;
            public int Slot;
            public float U;
            public float V;
            public int Begun; // number of the last touch with a reported down
            public int Ended; // number of the last touch with a reported up
        }

        readonly Growing<Finger> _fingers = new Growing<Finger>(16); // in order of their first event
        readonly Growing<HaloContact> _sorted = new Growing<HaloContact>(8);

        // The new events of the last call, those of one finger in order.
        public readonly Growing<HaloContact> Found = new Growing<HaloContact>(8);

        // `joining`: touches that began before are not hits. A frame that is not whole infers
        // nothing: the lost part may have the event, and the next frame repeats it.
        public void Count(
            Growing<HaloPointer> pointers, Growing<HaloContact> contacts, bool joining, bool whole)
        {
            Found.Clear();
            _sorted.CopyFrom(contacts);
            Sort(_sorted);
            for (var i = 0; i < _sorted.Count; i++) CountContact(in _sorted.Items[i], joining);
            for (var i = 0; i < pointers.Count; i++)
                CountPointer(in pointers.Items[i], joining, whole);
            if (whole) EndAllBut(pointers);
            ForgetAllBut(pointers);
            Sort(Found);
        }

        // Ends all open touches, for a service that is lost.
        public void Close()
        {
            Found.Clear();
            EndAllBut(null);
            Sort(Found);
        }

        void CountContact(in HaloContact contact, bool joining)
        {
            var index = Find(contact.Id, contact.Slot, contact.U, contact.V);
            ref var finger = ref _fingers.Items[index];
            if (!contact.IsUp)
            {
                Begin(ref finger, in contact);
                return;
            }
            if (contact.Contacts <= finger.Ended) return;
            if (contact.Contacts > finger.Begun && joining)
            {
                finger.Begun = finger.Ended = contact.Contacts; // It began before we joined.
                return;
            }
            Begin(ref finger, InferredDown(in finger, contact.Contacts));
            finger.Ended = contact.Contacts;
            Found.Add(in contact);
        }

        void CountPointer(in HaloPointer pointer, bool joining, bool whole)
        {
            var index = Find(pointer.Id, pointer.Slot, pointer.U, pointer.V);
            ref var finger = ref _fingers.Items[index];
            if (joining && pointer.Contacts > finger.Begun)
            {
                finger.Begun = pointer.Contacts;
                finger.Ended = pointer.IsTouching ? pointer.Contacts - 1 : pointer.Contacts;
            }
            if (!whole) return;
            Begin(ref finger, InferredDown(in finger, pointer.Contacts));
            if (!pointer.IsTouching) End(ref finger);
        }

        static HaloContact InferredDown(in Finger finger, int contacts) =>
            new HaloContact(
                false, finger.Id, finger.Slot, finger.U, finger.V, UnknownStrike, 0, contacts);

        void Begin(ref Finger finger, in HaloContact down)
        {
            if (down.Contacts <= finger.Begun) return;
            End(ref finger);
            finger.Begun = down.Contacts;
            finger.Ended = down.Contacts - 1; // Touches in between were lost and are over.
            Found.Add(in down);
        }

        void End(ref Finger finger)
        {
            if (finger.Ended >= finger.Begun) return;
            var up = new HaloContact(
                true, finger.Id, finger.Slot, finger.U, finger.V, 0, 0, finger.Begun);
            Found.Add(in up);
            finger.Ended = finger.Begun;
        }

        void EndAllBut(Growing<HaloPointer> living)
        {
            for (var i = 0; i < _fingers.Count; i++)
                if (!IsIn(living, _fingers.Items[i].Id)) End(ref _fingers.Items[i]);
        }

        void ForgetAllBut(Growing<HaloPointer> living)
        {
            var surplus = -MaxRemembered;
            for (var i = 0; i < _fingers.Count; i++)
                if (!IsIn(living, _fingers.Items[i].Id)) surplus++;
            for (var i = 0; i < _fingers.Count && surplus > 0;)
            {
                if (IsIn(living, _fingers.Items[i].Id))
                {
                    i++;
                    continue;
                }
                _fingers.RemoveAt(i);
                surplus--;
            }
        }

        static bool IsIn(Growing<HaloPointer> pointers, int id)
        {
            for (var i = 0; pointers != null && i < pointers.Count; i++)
                if (pointers.Items[i].Id == id) return true;
            return false;
        }

        // The index of a finger, with its newest place.
        int Find(int id, int slot, float u, float v)
        {
            var index = _fingers.Count - 1;
            while (index >= 0 && _fingers.Items[index].Id != id) index--;
            if (index < 0)
            {
                index = _fingers.Count;
                _fingers.Add(new Finger { Id = id });
            }
            ref var finger = ref _fingers.Items[index];
            finger.Slot = slot;
            finger.U = u;
            finger.V = v;
            return index;
        }

        // Insertion sort: stable, and a frame has few events.
        static void Sort(Growing<HaloContact> contacts)
        {
            for (var i = 1; i < contacts.Count; i++)
            {
                var moved = contacts.Items[i];
                var to = i;
                for (; to > 0 && HaloContact.IsAfter(in contacts.Items[to - 1], in moved); to--)
                    contacts.Items[to] = contacts.Items[to - 1];
                contacts.Items[to] = moved;
            }
        }
    }
}
