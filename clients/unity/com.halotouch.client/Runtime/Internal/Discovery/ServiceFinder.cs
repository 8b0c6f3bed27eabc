using System;
using System.Collections.Generic;
using System.Net;
using System.Net.NetworkInformation;
using System.Net.Sockets;

namespace HaloTouch.Internal
{
    // Asks by mDNS, on each network of this machine and on the loopback, which services there are.
    // Services announce themselves only where they can be reached.
    static class ServiceFinder
    {
        static readonly IPEndPoint Everybody = new IPEndPoint(IPAddress.Parse("224.0.0.251"), 5353);

        const int AskAgainMs = 500;
        const int PollUs = 20000;
        const int MaxServices = 256;

        // It waits for `seconds`; call it from a thread or a button.
        public static List<FoundService> Find(double seconds)
        {
            var found = new List<FoundService>();
            var sockets = Open();
            try
            {
                var endS = Clock.NowS + seconds;
                var askS = 0.0;
                while (Clock.NowS < endS && sockets.Count > 0)
                {
                    if (Clock.NowS >= askS)
                    {
                        foreach (var socket in sockets) Ask(socket);
                        askS = Clock.NowS + AskAgainMs / 1000.0;
                    }
                    foreach (var socket in sockets) Receive(socket, found);
                }
            }
            finally
            {
                foreach (var socket in sockets) socket.Close();
            }
            return found;
        }

        static List<Socket> Open()
        {
            var sockets = new List<Socket>();
            foreach (var network in NetworkInterface.GetAllNetworkInterfaces())
                foreach (var address in network.GetIPProperties().UnicastAddresses)
                    if (address.Address.AddressFamily == AddressFamily.InterNetwork)
                        TryOpen(address.Address, sockets);
            return sockets;
        }

        static void TryOpen(IPAddress address, List<Socket> sockets)
        {
            var socket = new Socket(AddressFamily.InterNetwork, SocketType.Dgram, ProtocolType.Udp);
            try
            {
                socket.Bind(new IPEndPoint(address, 0));
                socket.SetSocketOption(
                    SocketOptionLevel.IP, SocketOptionName.MulticastInterface, address.GetAddressBytes());
                sockets.Add(socket);
            }
            catch (SocketException)
            {
                socket.Close(); // A network that is down has no services.
            }
        }

        static void Ask(Socket socket)
        {
            try
            {
                socket.SendTo(DnsReader.Question(), Everybody);
            }
            catch (SocketException)
            {
                // The network has no multicast now; the question is repeated.
            }
        }

        static void Receive(Socket socket, List<FoundService> found)
        {
            var buffer = new byte[9000];
            EndPoint sender = new IPEndPoint(IPAddress.Any, 0);
            try
            {
                while (socket.Poll(PollUs, SelectMode.SelectRead))
                {
                    var length = socket.ReceiveFrom(buffer, ref sender);
                    var host = ((IPEndPoint)sender).Address.ToString();
                    foreach (var service in DnsReader.Read(buffer, length, host)) Add(service, found);
                }
            }
            catch (SocketException)
            {
                // An answer that cannot be received is lost; the question is repeated.
            }
        }

        static void Add(FoundService service, List<FoundService> found)
        {
            foreach (var each in found)
                if (each.Node == service.Node && each.Host == service.Host && each.ControlPort == service.ControlPort)
                    return;
            if (found.Count < MaxServices) found.Add(service);
        }
    }
}
