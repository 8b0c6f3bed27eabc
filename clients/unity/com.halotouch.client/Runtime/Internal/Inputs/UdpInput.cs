using System;
using System.Net;
using System.Net.Sockets;
using System.Threading;

namespace HaloTouch.Internal
{
    // Datagrams from a UDP port, received in a thread of its own. Its port is never shared: of two
    // clients with one port each would get a part, or one nothing.
    sealed class UdpInput : IInput
    {
        const int LargestBytes = 65507;
        const int KernelBytes = 1 << 20;
        const int WaitUs = 50000; // how late a lease, an answer or the end can be noticed

        readonly Source _source;
        readonly Socket _data;
        readonly Socket _control; // connected to the service's control port, or null
        readonly Lease _lease;
        readonly Thread _thread;
        readonly DatagramRing _ring = new DatagramRing();
        readonly byte[] _buffer = new byte[LargestBytes];
        readonly byte[] _answer = new byte[2048];
        volatile bool _closed;

        // InputException if a port cannot be opened or a host is not found.
        public UdpInput(Source source)
        {
            _source = source;
            if (source.HelloHost.Length > 0) _control = OpenControl(source);
            try
            {
                _data = OpenData(source, _control);
            }
            catch (InputException)
            {
                _control?.Close();
                throw;
            }
            Port = ((IPEndPoint)_data.LocalEndPoint).Port;
            if (_control != null) _lease = new Lease(source.Stream, Port);
            _thread = new Thread(Run) { IsBackground = true, Name = "halo" };
            _thread.Start();
        }

        // The port where the stream is received.
        public int Port { get; }

        public bool IsEnded => false;

        public int Dropped => _ring.Dropped;

        public string Problem
        {
            get
            {
                if (_lease == null) return "";
                if (_lease.State == LeaseState.Refused)
                    return "the service at " + _source.HelloHost + " refuses: " + _lease.Reason;
                if (_lease.State == LeaseState.Asking)
                    return "no answer from " + _source.HelloHost + ":" + _source.HelloPort + " yet";
                return _lease.IsOutdated ? "the service has a newer protocol: update this package" : "";
            }
        }

        public bool TryReceive(ref byte[] buffer, out int length, out double receivedS) =>
            _ring.TryPop(ref buffer, out length, out receivedS);

        public void Dispose()
        {
            if (_closed) return;
            _closed = true;
            _thread.Join();
            if (_control != null) Send(_lease.Goodbye());
            _data.Close();
            _control?.Close();
        }

        // The thread. It touches the sockets, the lease and the ring only.
        void Run()
        {
            while (!_closed)
            {
                try
                {
                    if (_control != null) RenewLease();
                    Receive();
                }
                catch (SocketException)
                {
                    Thread.Sleep(WaitUs / 1000); // The network is down: it is tried again.
                }
            }
        }

        void Receive()
        {
            if (!_data.Poll(WaitUs, SelectMode.SelectRead)) return;
            var length = _data.Receive(_buffer, 0, LargestBytes, SocketFlags.None, out var error);
            if (error == SocketError.Success) _ring.Push(_buffer, length, Clock.NowS);
        }

        void RenewLease()
        {
            while (_control.Available > 0)
            {
                var length = _control.Receive(_answer, 0, _answer.Length, SocketFlags.None, out var error);
                // An error says that no service listens there now: the hello is sent again.
                if (error == SocketError.Success) _lease.Handle(_answer, length);
            }
            Send(_lease.Due(Clock.NowS));
        }

        void Send(OscWriter message)
        {
            if (message == null) return;
            _control.Send(message.Bytes, 0, message.Length, SocketFlags.None, out var error);
            // The error is that of the message before, if no service listened there: this one was not sent.
            if (error != SocketError.Success)
                _control.Send(message.Bytes, 0, message.Length, SocketFlags.None, out _);
        }

        // On the address that is named, or on the one that the service sees.
        static Socket OpenData(Source source, Socket control)
        {
            var address = source.Host.Length > 0
                ? Resolve(source.Host)
                : ((IPEndPoint)control.LocalEndPoint).Address;
            var socket = new Socket(address.AddressFamily, SocketType.Dgram, ProtocolType.Udp);
            try
            {
                socket.ReceiveBufferSize = KernelBytes;
                // Mono allows by default that another program takes the port.
                socket.SetSocketOption(SocketOptionLevel.Socket, SocketOptionName.ReuseAddress, 0);
                socket.Bind(new IPEndPoint(address, source.Port));
                return socket;
            }
            catch (SocketException error)
            {
                socket.Close();
                throw new InputException(
                    "cannot listen on UDP port " + source.Port + " of " + address + " (" +
                    error.SocketErrorCode + "): close the other program that uses it, or choose another port");
            }
        }

        static Socket OpenControl(Source source)
        {
            var address = Resolve(source.HelloHost);
            var socket = new Socket(address.AddressFamily, SocketType.Dgram, ProtocolType.Udp);
            try
            {
                socket.Connect(new IPEndPoint(address, source.HelloPort));
                return socket;
            }
            catch (SocketException error)
            {
                socket.Close();
                throw new InputException(
                    "no network reaches " + source.HelloHost + " (" + error.SocketErrorCode + ")");
            }
        }

        static IPAddress Resolve(string host)
        {
            if (IPAddress.TryParse(host, out var address)) return address;
            try
            {
                foreach (var found in Dns.GetHostAddresses(host))
                    if (found.AddressFamily == AddressFamily.InterNetwork) return found;
            }
            catch (Exception error) when (error is SocketException || error is ArgumentException)
            {
            }
            throw new InputException("no IPv4 address of '" + host + "' is found; check the name");
        }
    }
}
