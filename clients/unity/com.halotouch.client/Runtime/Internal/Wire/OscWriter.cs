using System;
using System.Text;

namespace HaloTouch.Internal
{
    // Writes OSC messages and bundles into one array that grows.
    sealed class OscWriter
    {
        byte[] _bytes = new byte[512];
        int _sizeAt = -1;

        public byte[] Bytes => _bytes;

        public int Length { get; private set; }

        public OscWriter Start()
        {
            Length = 0;
            _sizeAt = -1;
            return this;
        }

        // A bundle with the timetag "immediately"; its messages follow.
        public OscWriter Bundle() => Text("#bundle").Int(0).Int(1);

        public OscWriter Message(string address, string tags)
        {
            return Text(address).Text(tags);
        }

        // A message in a bundle: its size is written by EndElement.
        public OscWriter Element(string address, string tags)
        {
            _sizeAt = Length;
            return Int(0).Message(address, tags);
        }

        public OscWriter EndElement()
        {
            var end = Length;
            Length = _sizeAt;
            Int(end - _sizeAt - 4);
            Length = end;
            return this;
        }

        public OscWriter Int(int value)
        {
            Reserve(4);
            _bytes[Length++] = (byte)(value >> 24);
            _bytes[Length++] = (byte)(value >> 16);
            _bytes[Length++] = (byte)(value >> 8);
            _bytes[Length++] = (byte)value;
            return this;
        }

        public OscWriter Float(float value) => Int(FloatBits.ToBits(value));

        public OscWriter Text(string text)
        {
            var count = Encoding.UTF8.GetByteCount(text);
            Reserve(count + 4);
            Encoding.UTF8.GetBytes(text, 0, text.Length, _bytes, Length);
            for (var i = count; i < count + 4 - count % 4; i++) _bytes[Length + i] = 0;
            Length += count + 4 - count % 4;
            return this;
        }

        void Reserve(int count)
        {
            if (Length + count > _bytes.Length)
                Array.Resize(ref _bytes, Math.Max(2 * _bytes.Length, Length + count));
        }
    }
}
