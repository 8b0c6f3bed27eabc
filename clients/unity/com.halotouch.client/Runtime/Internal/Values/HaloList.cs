using System;
using HaloTouch.Internal;

namespace HaloTouch
{
    /// <summary>
    /// Values of a frame. `foreach` does not allocate. The values are valid until the next frame:
    /// copy what you need later.
    /// </summary>
    public readonly struct HaloList<T>
    {
        readonly Growing<T> _values;

        internal HaloList(Growing<T> values)
        {
            _values = values;
        }

        /// <summary>Number of values.</summary>
        public int Count => _values == null ? 0 : _values.Count;

        /// <summary>One value; 0 is the first.</summary>
        public T this[int index]
        {
            get
            {
                if ((uint)index >= (uint)Count) throw new ArgumentOutOfRangeException(nameof(index));
                return _values.Items[index];
            }
        }

        /// <summary>For `foreach`.</summary>
        public Enumerator GetEnumerator() => new Enumerator(this);

        /// <summary>For `foreach`.</summary>
        public struct Enumerator
        {
            readonly HaloList<T> _list;
            int _index;

            internal Enumerator(HaloList<T> list)
            {
                _list = list;
                _index = -1;
            }

            /// <summary>The value.</summary>
            public T Current => _list[_index];

            /// <summary>Goes on; false at the end.</summary>
            public bool MoveNext() => ++_index < _list.Count;
        }
    }
}
