using System;
using System.Globalization;

namespace HaloTouch.Internal
{
    enum SourceKind { Osc, WebSocket, File }

    // A source as text, with the words of the Python client: `osc://127.0.0.1:4256`,
    // `osc://?hello=192.168.0.5:4257&rate=30`, `ws://127.0.0.1:4258/halo`, `recording.jsonl`. All but
    // files: `node=`, `surface=` and `follow=all`.
    sealed class Source
    {
        public const int DefaultPort = 4256;
        public const int DefaultControlPort = 4257;
        public const int DefaultWebPort = 4258;
        const string Examples =
            "use osc://127.0.0.1:4256, osc://?hello=127.0.0.1:4257, ws://127.0.0.1:4258/halo or FILE.jsonl";

        public SourceKind Kind { get; private set; }
        public string Host { get; private set; } = ""; // where OSC is received; empty: where the service sees us
        public int Port { get; private set; } // 0: a free one
        public string HelloHost { get; private set; } = ""; // empty: the service sends by its settings
        public int HelloPort { get; private set; }
        public string Stream { get; private set; } = "frames";
        public string Url { get; private set; } = ""; // of the WebSocket
        public string Path { get; private set; } = ""; // of the file
        public Follow Follow { get; private set; }

        // InputException for a text that is no source.
        public static Source Parse(string text)
        {
            text = text.Trim();
            var scheme = text.IndexOf("://", StringComparison.Ordinal);
            if (scheme < 0)
            {
                if (!text.EndsWith(".jsonl", StringComparison.OrdinalIgnoreCase)) throw Unknown(text);
                return new Source { Kind = SourceKind.File, Path = text };
            }
            var name = text.Substring(0, scheme);
            var rest = text.Substring(scheme + 3);
            if (name == "osc") return new Source { Kind = SourceKind.Osc }.ReadOsc(rest);
            if (name == "ws" || name == "wss")
                return new Source { Kind = SourceKind.WebSocket }.ReadWeb(name, rest);
            throw Unknown(text);
        }

        static InputException Unknown(string text) =>
            new InputException("unknown source '" + text + "'; " + Examples);

        Source ReadOsc(string rest)
        {
            var rate = "";
            var place = ReadSettings(rest, (name, value) =>
            {
                if (name == "rate") rate = value;
                if (name != "hello") return name == "rate";
                HelloHost = ReadPlace(value, DefaultControlPort, out var port);
                HelloPort = port;
                return true;
            });
            var hello = HelloHost.Length > 0;
            Host = ReadPlace(place.TrimEnd('/'), hello ? 0 : DefaultPort, out var found);
            Port = found;
            if (Host.Length == 0 && !hello) Host = "127.0.0.1";
            if (rate.Length > 0) Stream += ",rate=" + rate;
            if (rate.Length > 0 && !hello) throw new InputException("osc: rate needs hello=HOST:PORT");
            return this;
        }

        Source ReadWeb(string scheme, string rest)
        {
            var place = ReadSettings(rest, (name, value) => false);
            var slash = place.IndexOf('/');
            var path = slash < 0 ? "" : place.Substring(slash);
            var host = ReadPlace(slash < 0 ? place : place.Substring(0, slash), DefaultWebPort, out var port);
            if (host.Length == 0 || path != "" && path != "/" && path != "/halo")
                throw new InputException("ws needs a host, a port and /halo; " + Examples);
            if (host.IndexOf(':') >= 0) host = "[" + host + "]";
            Url = scheme + "://" + host + ":" + port + "/halo";
            return this;
        }

        // Reads what follows `?`; returns what comes before.
        string ReadSettings(string rest, Func<string, string, bool> more)
        {
            var mark = rest.IndexOf('?');
            if (mark < 0) return rest;
            string node = "", surface = "";
            var everything = false;
            foreach (var setting in rest.Substring(mark + 1).Split('&'))
            {
                var equals = setting.IndexOf('=');
                var name = equals < 0 ? setting : setting.Substring(0, equals);
                var value = equals < 0 ? "" : Uri.UnescapeDataString(setting.Substring(equals + 1));
                if (name == "node") node = value;
                else if (name == "surface") surface = value;
                else if (name == "follow") everything = value == "all";
                else if (!more(name, value))
                    throw new InputException("unknown setting '" + name + "' of a source");
            }
            Follow = new Follow(node, surface, everything);
            return rest.Substring(0, mark);
        }

        // `HOST`, `HOST:PORT`, `[IPV6]:PORT` or nothing.
        static string ReadPlace(string text, int defaultPort, out int port)
        {
            port = defaultPort;
            var colon = text.LastIndexOf(':');
            if (colon >= 0 && colon > text.LastIndexOf(']'))
            {
                var number = text.Substring(colon + 1);
                if (!int.TryParse(number, NumberStyles.None, CultureInfo.InvariantCulture, out port) ||
                    port > 65535)
                    throw new InputException("a port is a number from 1 to 65535, not '" + number + "'");
                text = text.Substring(0, colon);
            }
            return text.Trim('[', ']');
        }
    }
}
