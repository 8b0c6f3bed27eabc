using System;

namespace HaloTouch.Internal
{
    // Reads one OSC message. It never reads beyond its end. After the first error each read gives
    // 0 and no bytes are left, so that no loop goes on; callers look at Error once, at the end.
    struct OscReader
    {
        readonly byte[] _bytes;
        readonly int _end;
        int _position;

        public string Error { get; private set; }

        public int Left => Error == null ? _end - _position : 0;

        public int Position => _position;

        public OscReader(byte[] bytes, int start, int end)
        {
            _bytes = bytes;
            _end = end;
            _position = start;
            Error = null;
        }

        public void Fail(string error)
        {
            if (Error == null) Error = error;
        }

        public void Require(bool condition, string error)
        {
            if (!condition) Fail(error);
        }

        public int Int()
        {
            if (Left < 4)
            {
                Fail("a number is cut off");
                return 0;
            }
            var at = _position;
            _position += 4;
            return _bytes[at] << 24 | _bytes[at + 1] << 16 | _bytes[at + 2] << 8 | _bytes[at + 3];
        }

        public float Float()
        {
            var value = FloatBits.ToFloat(Int());
            if (!float.IsNaN(value) && !float.IsInfinity(value)) return value;
            Fail("each number must be finite");
            return 0;
        }

        // A string: its bytes are from start to stop.
        public void Text(out int start, out int stop)
        {
            start = stop = _position;
            if (Error != null) return;
            stop = Array.IndexOf(_bytes, (byte)0, start, _end - start);
            if (stop < 0) Fail("a string has no end");
            else if (stop + 4 - (stop - start) % 4 > _end) Fail("a string is not padded");
            else
            {
                _position = stop + 4 - (stop - start) % 4;
                return;
            }
            stop = start;
        }

        // A string with the pattern of a name, without allocation if it was read before.
        public string Name(NameCache names, NameKind kind)
        {
            Text(out var start, out var stop);
            if (Error != null) return "";
            var name = names.Find(_bytes, start, stop, kind);
            if (name == null) Fail("a name is invalid");
            return name ?? "";
        }

        // Type tags, which must begin with those given. The number of further ones.
        public int Tags(string expected)
        {
            Text(out var start, out var stop);
            if (Error != null) return 0;
            if (!Ascii.StartsWith(_bytes, start, stop, expected)) Fail("unexpected types");
            return stop - start - expected.Length;
        }

        public void Skip(int count)
        {
            if (count > Left) Fail("bytes are missing");
            else _position += count;
        }
    }
}
