namespace HaloTouch.Internal
{
    enum NameKind { Node, Session, Version, Program }

    // Names of nodes, surfaces, sessions and versions as strings, each created once. Bounded: forged
    // names replace the oldest.
    sealed class NameCache
    {
        const int MaxNames = 256;

        readonly string[] _names = new string[MaxNames];
        int _count;
        int _oldest;

        // Null if the bytes do not have the pattern of the kind.
        public string Find(byte[] bytes, int start, int stop, NameKind kind)
        {
            if (!IsValid(bytes, start, stop, kind)) return null;
            for (var i = 0; i < _count; i++)
                if (Ascii.Equal(bytes, start, stop, _names[i])) return _names[i];
            return Add(Ascii.Text(bytes, start, stop));
        }

        string Add(string name)
        {
            if (_count < MaxNames) return _names[_count++] = name;
            _names[_oldest] = name;
            _oldest = (_oldest + 1) % MaxNames;
            return name;
        }

        static bool IsValid(byte[] bytes, int start, int stop, NameKind kind)
        {
            if (kind == NameKind.Version) return IsVersion(bytes, start, stop);
            if (kind == NameKind.Program) return IsProgram(bytes, start, stop);
            if (stop - start < 1 || stop - start > 32) return false;
            for (var i = start; i < stop; i++)
                if (!IsNameByte(bytes[i])) return false;
            // From g to z: no tool can read such a name as a number.
            return kind != NameKind.Session || bytes[start] >= 'g' && bytes[start] <= 'z';
        }

        static bool IsNameByte(byte one) =>
            one >= 'a' && one <= 'z' || IsDigit(one) || one == '_' || one == '-';

        static bool IsDigit(byte one) => one >= '0' && one <= '9';

        // The version of a program, or nothing.
        static bool IsProgram(byte[] bytes, int start, int stop)
        {
            if (stop - start > 32) return false;
            for (var i = start; i < stop; i++)
            {
                var one = bytes[i];
                var isFurther = one >= 'A' && one <= 'Z' || one == '.' || one == '+';
                if (!isFurther && !IsNameByte(one)) return false;
            }
            return true;
        }

        // Three numbers of 1 to 4 digits, with dots between them.
        static bool IsVersion(byte[] bytes, int start, int stop)
        {
            var dots = 0;
            var digits = 0;
            for (var i = start; i < stop; i++)
            {
                if (IsDigit(bytes[i])) digits++;
                else if (bytes[i] == '.' && digits > 0)
                {
                    dots++;
                    digits = 0;
                }
                else return false;
                if (digits > 4) return false;
            }
            return dots == 2 && digits > 0;
        }
    }
}
