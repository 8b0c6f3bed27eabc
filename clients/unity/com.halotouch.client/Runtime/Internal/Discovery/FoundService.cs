namespace HaloTouch.Internal
{
    // A service that has announced itself by mDNS.
    readonly struct FoundService
    {
        public readonly string Node;
        public readonly string Surface;
        public readonly string Host; // an IPv4 address
        public readonly int ControlPort;

        public FoundService(string node, string surface, string host, int controlPort)
        {
            Node = node;
            Surface = surface;
            Host = host;
            ControlPort = controlPort;
        }

        // A source that asks this service for its stream.
        public string Source => "osc://?hello=" + Host + ":" + ControlPort + "&node=" + Node;
    }
}
