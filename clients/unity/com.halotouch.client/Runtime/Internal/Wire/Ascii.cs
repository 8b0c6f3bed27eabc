namespace HaloTouch.Internal
{
    // Compares bytes with texts without making strings of them.
    static class Ascii
    {
        public static bool StartsWith(byte[] bytes, int start, int stop, string text)
        {
            if (stop - start < text.Length) return false;
            for (var i = 0; i < text.Length; i++)
                if (bytes[start + i] != text[i]) return false;
            return true;
        }

        public static bool Equal(byte[] bytes, int start, int stop, string text) =>
            stop - start == text.Length && StartsWith(bytes, start, stop, text);

        public static string Text(byte[] bytes, int start, int stop)
        {
            var text = new char[stop - start];
            for (var i = start; i < stop; i++) text[i - start] = (char)bytes[i];
            return new string(text);
        }
    }
}
