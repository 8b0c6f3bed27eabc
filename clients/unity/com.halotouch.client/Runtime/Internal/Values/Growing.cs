using System;

namespace HaloTouch.Internal
{
    // A list that is cleared and filled again without allocation. Callers bound its size.
    sealed class Growing<T>
    {
        public T[] Items;
        public int Count;

        public Growing(int capacity)
        {
            Items = new T[capacity];
        }

        public void Add(in T item)
        {
            if (Count == Items.Length) Array.Resize(ref Items, Math.Max(4, 2 * Count));
            Items[Count++] = item;
        }

        public void RemoveAt(int index)
        {
            Count--;
            Array.Copy(Items, index + 1, Items, index, Count - index);
            Items[Count] = default(T);
        }

        public void Clear()
        {
            Count = 0;
        }

        public void CopyFrom(Growing<T> other)
        {
            Clear();
            for (var i = 0; i < other.Count; i++) Add(in other.Items[i]);
        }
    }
}
