using System;
using System.Collections.Generic;
using System.Text;

namespace HaloTouch.Internal
{
    // Reads the answers of mDNS that name halo services. Any bytes are accepted: what is malformed
    // gives no service. The work is bounded by the size of the datagram.
    sealed class DnsReader
    {
        public const string Service = "_osc._udp.local";

        const int HeaderBytes = 12;
        const int MaxRecords = 256;
        const int MaxName = 255;
        const int MaxJumps = 16; // compressed names refer back to others
        const int A = 1, Pointer = 12, Text = 16, Server = 33;

        readonly byte[] _bytes;
        readonly int _length;
        int _position;
        bool _failed;

        readonly List<string> _instances = new List<string>();
        readonly Dictionary<string, int> _ports = new Dictionary<string, int>();
        readonly Dictionary<string, string> _hosts = new Dictionary<string, string>();
        readonly Dictionary<string, string> _addresses = new Dictionary<string, string>();
        readonly Dictionary<string, Dictionary<string, string>> _texts =
            new Dictionary<string, Dictionary<string, string>>();

        DnsReader(byte[] bytes, int length)
        {
            _bytes = bytes;
            _length = length;
        }

        // `sender`: the address that is used when the answer names none.
        public static List<FoundService> Read(byte[] bytes, int length, string sender)
        {
            var reader = new DnsReader(bytes, length);
            reader.ReadAll();
            return reader.Services(sender);
        }

        // A question for all services, answered to the port that asks.
        public static byte[] Question()
        {
            var bytes = new List<byte> { 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0 };
            foreach (var label in Service.Split('.'))
            {
                bytes.Add((byte)label.Length);
                bytes.AddRange(Encoding.ASCII.GetBytes(label));
            }
            bytes.AddRange(new byte[] { 0, 0, Pointer, 0x80, 1 });
            return bytes.ToArray();
        }

        List<FoundService> Services(string sender)
        {
            var found = new List<FoundService>();
            foreach (var instance in _instances)
            {
                if (!_ports.TryGetValue(instance, out var port)) continue;
                // Other programs announce OSC, too: ours name their node and session.
                if (!_texts.TryGetValue(instance, out var text)) continue;
                if (!text.TryGetValue("node", out var node) || !text.ContainsKey("session")) continue;
                text.TryGetValue("surface", out var surface);
                if (!_addresses.TryGetValue(_hosts[instance], out var address)) address = sender;
                found.Add(new FoundService(node, surface ?? "", address, port));
            }
            return found;
        }

        void ReadAll()
        {
            if (_length < HeaderBytes || (_bytes[2] & 0x80) == 0) return; // no answer
            var questions = Short(4);
            var records = Math.Min(MaxRecords, Short(6) + Short(8) + Short(10));
            _position = HeaderBytes;
            for (var i = 0; i < questions && !_failed; i++)
            {
                Name();
                Skip(4);
            }
            for (var i = 0; i < records && !_failed; i++) Record();
        }

        void Record()
        {
            var name = Name();
            if (!Has(10)) return;
            var type = Short(_position);
            var size = Short(_position + 8);
            Skip(10);
            if (!Has(size)) return;
            var end = _position + size;
            if (type == Pointer && name == Service && _instances.Count < MaxRecords) AddOnce(Name());
            else if (type == Server && size > 6) ReadServer(name);
            else if (type == Text) _texts[name] = Texts(end);
            else if (type == A && size == 4)
                _addresses[name] = string.Join(
                    ".", _bytes[_position], _bytes[_position + 1], _bytes[_position + 2], _bytes[_position + 3]);
            _position = end;
        }

        void AddOnce(string instance)
        {
            if (!_instances.Contains(instance)) _instances.Add(instance);
        }

        void ReadServer(string name)
        {
            _ports[name] = Short(_position + 4);
            Skip(6);
            _hosts[name] = Name();
        }

        Dictionary<string, string> Texts(int end)
        {
            var found = new Dictionary<string, string>();
            while (_position < end)
            {
                var size = Math.Min(_bytes[_position++], end - _position);
                var entry = Encoding.UTF8.GetString(_bytes, _position, size);
                _position += size;
                var equals = entry.IndexOf('=');
                if (equals > 0) found[entry.Substring(0, equals)] = entry.Substring(equals + 1);
            }
            return found;
        }

        // A name in lower case, with dots.
        string Name()
        {
            var name = new StringBuilder();
            var at = _position;
            var jumps = 0;
            while (!_failed)
            {
                if (at >= _length || name.Length > MaxName) return Fail();
                var size = _bytes[at++];
                if (size == 0) break;
                if (size >= 0xC0)
                {
                    if (at >= _length || ++jumps > MaxJumps) return Fail();
                    if (jumps == 1) _position = at + 1;
                    at = (size & 0x3F) << 8 | _bytes[at];
                    continue;
                }
                if (at + size > _length) return Fail();
                name.Append(name.Length > 0 ? "." : "").Append(Encoding.UTF8.GetString(_bytes, at, size));
                at += size;
            }
            if (jumps == 0) _position = at;
            return name.ToString().ToLowerInvariant();
        }

        string Fail()
        {
            _failed = true;
            return "";
        }

        bool Has(int count)
        {
            if (count > _length - _position) _failed = true;
            return !_failed;
        }

        void Skip(int count)
        {
            if (Has(count)) _position += count;
        }

        int Short(int at) => _bytes[at] << 8 | _bytes[at + 1];
    }
}
