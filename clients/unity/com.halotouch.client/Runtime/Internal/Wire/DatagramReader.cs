namespace HaloTouch.Internal
{
    // OSC bytes to the content of a datagram, by the table of protocol/SPEC.md. A malformed datagram
    // is refused as a whole. The work is bounded by its size and by the depth of its bundles.
    sealed class DatagramReader
    {
        public const int MaxBytes = 65507;
        const int MaxDepth = 4;
        const string Bundle = "#bundle\0";
        const string Root = "/halo/1/";
        const string AnyRoot = "/halo/";

        readonly NameCache _names = new NameCache();
        readonly MessageReader _messages;
        string _error;

        public DatagramReader()
        {
            _messages = new MessageReader(_names);
        }

        // Whether the last datagram had a message of another major version of the protocol.
        public bool SawOtherMajor { get; private set; }

        // Null, or why the datagram is refused.
        public string Read(byte[] bytes, int length, Datagram into)
        {
            into.Clear();
            _error = null;
            SawOtherMajor = false;
            if (length == 0) return "the datagram is empty";
            if (length > MaxBytes || length > bytes.Length) return "the datagram is too large";
            ReadPacket(bytes, 0, length, MaxDepth, into);
            if (_error == null && into.OpenCount > 0) _error = "the alive list is missing";
            return _error;
        }

        void ReadPacket(byte[] bytes, int start, int end, int depth, Datagram into)
        {
            if ((end - start) % 4 != 0) _error = "the size of an OSC packet must be a multiple of 4";
            else if (!Ascii.StartsWith(bytes, start, end, Bundle)) ReadMessage(bytes, start, end, into);
            else if (depth == 0) _error = "bundles are nested too deep";
            else if (end - start < 16) _error = "a bundle has at least 16 bytes";
            else ReadElements(bytes, start + 16, end, depth, into);
        }

        void ReadElements(byte[] bytes, int start, int end, int depth, Datagram into)
        {
            while (start < end && _error == null)
            {
                // A size is always there: start and end differ by a multiple of 4.
                var size = new OscReader(bytes, start, end).Int();
                start += 4;
                if (size <= 0 || size > end - start) _error = "an element is cut off";
                else ReadPacket(bytes, start, start + size, depth - 1, into);
                start += size;
            }
        }

        void ReadMessage(byte[] bytes, int start, int end, Datagram into)
        {
            var reader = new OscReader(bytes, start, end);
            reader.Text(out var first, out var stop);
            if (reader.Error == null && (first == stop || bytes[first] != '/'))
                reader.Fail("an OSC address begins with a slash");
            if (reader.Error == null && Ascii.StartsWith(bytes, first, stop, Root))
                ReadHalo(ref reader, bytes, first + Root.Length, stop, into);
            else if (reader.Error == null && IsOtherMajor(bytes, first, stop))
                SawOtherMajor = true;
            _error = reader.Error;
        }

        static bool IsOtherMajor(byte[] bytes, int start, int stop)
        {
            var digit = start + AnyRoot.Length;
            return Ascii.StartsWith(bytes, start, stop, AnyRoot) && digit < stop &&
                bytes[digit] >= '0' && bytes[digit] <= '9';
        }

        void ReadHalo(ref OscReader reader, byte[] bytes, int start, int stop, Datagram into)
        {
            var slash = start;
            while (slash < stop && bytes[slash] != '/') slash++;
            if (slash == stop) return;
            var kind = MessageReader.KindOf(bytes, slash + 1, stop);
            if (kind == MessageKind.Unknown) return;
            var surface = _names.Find(bytes, start, slash, NameKind.Node);
            if (surface == null || surface == "control" || surface == "sim")
                reader.Fail("the name of the surface is invalid");
            else _messages.Read(ref reader, kind, surface, into);
        }
    }
}
