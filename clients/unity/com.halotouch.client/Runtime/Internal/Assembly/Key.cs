namespace HaloTouch.Internal
{
    // State belongs to a node, a surface and a session.
    readonly struct Key
    {
        public readonly string Node;
        public readonly string Surface;
        public readonly string Session;

        public Key(string node, string surface, string session)
        {
            Node = node;
            Surface = surface;
            Session = session;
        }

        public static bool Same(in Key a, in Key b) => SamePlace(in a, in b) && a.Session == b.Session;

        public static bool SamePlace(in Key a, in Key b) => a.Node == b.Node && a.Surface == b.Surface;
    }
}
