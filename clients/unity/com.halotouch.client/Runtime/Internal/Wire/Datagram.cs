namespace HaloTouch.Internal
{
    enum ItemKind { Part, Scene, Homography, Pose, Health }

    // A part of a frame, or a report.
    sealed class Item
    {
        public ItemKind Kind;
        public string Surface;
        public readonly Part Part = new Part();
        public HaloScene Scene;
        public HaloHomography Homography;
        public HaloPose Pose;
        public HaloHealth Health;
    }

    // The content of one datagram, in order. Used again for the next one.
    sealed class Datagram
    {
        const int MaxReused = 16;

        readonly Growing<Item> _pool = new Growing<Item>(MaxReused);
        readonly Growing<Item> _open = new Growing<Item>(4); // frames before their alive list
        int _used;

        public readonly Growing<Item> Items = new Growing<Item>(MaxReused);

        public int OpenCount => _open.Count;

        public void Clear()
        {
            Items.Clear();
            _open.Clear();
            _used = 0;
        }

        public Item AddReport(ItemKind kind, string surface)
        {
            var item = Next(kind, surface);
            Items.Add(in item);
            return item;
        }

        public void Open(string surface, in Header header)
        {
            var item = Next(ItemKind.Part, surface);
            item.Part.Start(surface, in header);
            _open.Add(in item);
        }

        // The frame of a surface that has begun and has no alive list yet, or null.
        public Part FindOpen(string surface)
        {
            for (var i = _open.Count - 1; i >= 0; i--)
                if (_open.Items[i].Surface == surface) return _open.Items[i].Part;
            return null;
        }

        public void Close(Part part)
        {
            for (var i = _open.Count - 1; i >= 0; i--)
            {
                if (_open.Items[i].Part != part) continue;
                Items.Add(in _open.Items[i]);
                _open.RemoveAt(i);
                return;
            }
        }

        Item Next(ItemKind kind, string surface)
        {
            var item = _used < _pool.Count ? _pool.Items[_used] : new Item();
            if (_used == _pool.Count && _used < MaxReused) _pool.Add(in item);
            _used++;
            item.Kind = kind;
            item.Surface = surface;
            return item;
        }
    }
}
