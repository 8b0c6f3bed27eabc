namespace HaloTouch.Internal
{
    // What to follow: one service, named or the first that sends a frame, or everything.
    readonly struct Follow
    {
        public readonly string Node; // null or empty, as in default(Follow): any
        public readonly string Surface; // the same
        public readonly bool Everything;

        public Follow(string node, string surface, bool everything)
        {
            Node = node;
            Surface = surface;
            Everything = everything;
        }

        public bool Matches(string node, string surface) =>
            (string.IsNullOrEmpty(Node) || Node == node) &&
            (string.IsNullOrEmpty(Surface) || Surface == surface);
    }
}
