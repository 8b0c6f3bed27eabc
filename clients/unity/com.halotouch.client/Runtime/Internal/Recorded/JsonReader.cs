using System.Collections.Generic;
using System.Globalization;
using System.Text;

namespace HaloTouch.Internal
{
    // Reads one line of JSON: objects, lists, texts, numbers (double), true, false and null.
    // InputException for anything else; the depth is bounded.
    sealed class JsonReader
    {
        const int MaxDepth = 16;

        readonly string _text;
        int _position;

        JsonReader(string text)
        {
            _text = text;
        }

        public static object Read(string text)
        {
            var reader = new JsonReader(text);
            var value = reader.Value(0);
            if (reader.Peek() != '\0') throw reader.Error("more text follows");
            return value;
        }

        InputException Error(string what) =>
            new InputException("no JSON: " + what + " at character " + (_position + 1));

        // The next character that is no space; it is not read. '\0' at the end.
        char Peek()
        {
            while (_position < _text.Length && char.IsWhiteSpace(_text[_position])) _position++;
            return _position < _text.Length ? _text[_position] : '\0';
        }

        void Expect(char wanted)
        {
            if (Peek() != wanted) throw Error("'" + wanted + "' is missing");
            _position++;
        }

        bool Accept(char wanted)
        {
            if (Peek() != wanted) return false;
            _position++;
            return true;
        }

        object Value(int depth)
        {
            if (depth > MaxDepth) throw Error("it is nested too deep");
            var next = Peek();
            if (next == '{') return Object(depth);
            if (next == '[') return List(depth);
            if (next == '"') return Text();
            if (next == 't') return Word("true", true);
            if (next == 'f') return Word("false", false);
            if (next == 'n') return Word("null", null);
            return Number();
        }

        Dictionary<string, object> Object(int depth)
        {
            var found = new Dictionary<string, object>();
            Expect('{');
            if (Accept('}')) return found;
            do
            {
                if (Peek() != '"') throw Error("a name is missing");
                var name = Text();
                Expect(':');
                found[name] = Value(depth + 1);
            }
            while (Accept(','));
            Expect('}');
            return found;
        }

        List<object> List(int depth)
        {
            var found = new List<object>();
            Expect('[');
            if (Accept(']')) return found;
            do found.Add(Value(depth + 1));
            while (Accept(','));
            Expect(']');
            return found;
        }

        object Word(string word, object value)
        {
            if (string.CompareOrdinal(_text, _position, word, 0, word.Length) != 0)
                throw Error("an unknown word");
            _position += word.Length;
            return value;
        }

        object Number()
        {
            var start = _position;
            while (_position < _text.Length && "+-.eE0123456789".IndexOf(_text[_position]) >= 0) _position++;
            var digits = _text.Substring(start, _position - start);
            if (double.TryParse(digits, NumberStyles.Float, CultureInfo.InvariantCulture, out var number))
                return number;
            throw Error("a value is missing");
        }

        string Text()
        {
            var found = new StringBuilder();
            for (_position++; _position < _text.Length; _position++)
            {
                var next = _text[_position];
                if (next == '"')
                {
                    _position++;
                    return found.ToString();
                }
                found.Append(next == '\\' ? Escaped() : next);
            }
            throw Error("a text has no end");
        }

        char Escaped()
        {
            _position++;
            if (_position >= _text.Length) throw Error("a text has no end");
            var plain = "\"\\/bfnrt".IndexOf(_text[_position]);
            if (plain >= 0) return "\"\\/\b\f\n\r\t"[plain];
            if (_text[_position] != 'u' || _position + 4 >= _text.Length) throw Error("an unknown escape");
            var digits = _text.Substring(_position + 1, 4);
            if (!ushort.TryParse(digits, NumberStyles.AllowHexSpecifier, CultureInfo.InvariantCulture, out var code))
                throw Error("an unknown escape");
            _position += 4;
            return (char)code;
        }
    }
}
