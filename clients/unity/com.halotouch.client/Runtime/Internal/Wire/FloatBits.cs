using System.Runtime.InteropServices;

namespace HaloTouch.Internal
{
    // A float32 and its bits, without allocation and in each API level of Unity.
    [StructLayout(LayoutKind.Explicit)]
    struct FloatBits
    {
        [FieldOffset(0)] int _bits;
        [FieldOffset(0)] float _value;

        public static float ToFloat(int bits) => new FloatBits { _bits = bits }._value;

        public static int ToBits(float value) => new FloatBits { _value = value }._bits;
    }
}
