using System;
using System.Collections.Generic;

namespace HaloTouch.Internal
{
    // Typed access to an object of JSON. InputException names what is missing or has a wrong type.
    readonly struct JsonFields
    {
        readonly Dictionary<string, object> _fields;

        public JsonFields(object value)
        {
            _fields = value as Dictionary<string, object>;
            if (_fields == null) throw new InputException("an object is expected");
        }

        public bool Has(string name) => _fields.ContainsKey(name);

        public string Text(string name) => Get(name) as string ?? throw Wrong(name, "a text");

        public string TextOr(string name, string missing) => Has(name) ? Text(name) : missing;

        public double Number(string name) =>
            Get(name) is double number ? number : throw Wrong(name, "a number");

        public float Float(string name)
        {
            var number = Number(name);
            return Math.Abs(number) <= float.MaxValue ? (float)number : throw Wrong(name, "a float32");
        }

        public int Int(string name) => (int)Long(name, int.MinValue, int.MaxValue);

        public int IntOr(string name, int missing) => Has(name) ? Int(name) : missing;

        public long Long(string name, long least, long most)
        {
            var number = Number(name);
            return number >= least && number <= most ? (long)number : throw Wrong(name, "a whole number");
        }

        // A number, or a word of the enumeration.
        public int Word<T>(string name) where T : struct
        {
            if (!(Get(name) is string word)) return Int(name);
            var known = Array.FindIndex(
                Enum.GetNames(typeof(T)), each => each.Equals(word.Replace("_", ""), StringComparison.OrdinalIgnoreCase));
            return known >= 0 ? known : throw Wrong(name, "one of its words");
        }

        public List<object> List(string name) => Get(name) as List<object> ?? throw Wrong(name, "a list");

        object Get(string name) =>
            _fields.TryGetValue(name, out var value) ? value : throw new InputException("no '" + name + "'");

        static InputException Wrong(string name, string wanted) =>
            new InputException("'" + name + "' must be " + wanted);
    }
}
