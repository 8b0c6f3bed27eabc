namespace HaloTouch.Internal
{
    // The hand-off from the receiver's thread to the main thread: the thread copies each datagram in,
    // the main thread exchanges its buffer for the oldest one. Bounded: when the main thread is busy,
    // as while a scene loads, the oldest datagrams are dropped. Each frame is the complete state, and
    // the assembler infers the touches of dropped ones.
    sealed class DatagramRing
    {
        const int Slots = 512; // some seconds
        const int FirstBytes = 2048;

        struct Slot
        {
            public byte[] Bytes;
            public int Length;
            public double ReceivedS;
        }

        readonly Slot[] _slots = new Slot[Slots];
        readonly object _lock = new object();
        int _first;
        int _count;
        int _dropped;

        public int Dropped
        {
            get
            {
                lock (_lock) return _dropped;
            }
        }

        public void Push(byte[] bytes, int length, double receivedS)
        {
            lock (_lock)
            {
                if (_count == Slots) DropOldest();
                ref var slot = ref _slots[(_first + _count) % Slots];
                if (slot.Bytes == null || slot.Bytes.Length < length)
                    slot.Bytes = new byte[length > FirstBytes ? length : FirstBytes];
                System.Buffer.BlockCopy(bytes, 0, slot.Bytes, 0, length);
                slot.Length = length;
                slot.ReceivedS = receivedS;
                _count++;
            }
        }

        public bool TryPop(ref byte[] buffer, out int length, out double receivedS)
        {
            lock (_lock)
            {
                length = 0;
                receivedS = 0;
                if (_count == 0) return false;
                ref var slot = ref _slots[_first];
                length = slot.Length;
                receivedS = slot.ReceivedS;
                var given = buffer;
                buffer = slot.Bytes;
                slot.Bytes = given;
                _first = (_first + 1) % Slots;
                _count--;
                return true;
            }
        }

        void DropOldest()
        {
            _first = (_first + 1) % Slots;
            _count--;
            _dropped++;
        }
    }
}
