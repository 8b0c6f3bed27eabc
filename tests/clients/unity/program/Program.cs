// The test program of the Unity client's core. It reads lines and writes lines of JSON; the tests in
// Python compare them with the golden vectors and with the Python client.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.IO;
using System.Threading;
using HaloTouch;
using HaloTouch.Internal;

static partial class Program
{
    static readonly TextWriter Out = new StreamWriter(Console.OpenStandardOutput()) { AutoFlush = false };

    static int Main(string[] arguments)
    {
        try
        {
            return Run(arguments[0], arguments.Length > 1 ? arguments[1] : "", arguments);
        }
        catch (InputException error)
        {
            Console.Error.WriteLine(error.Message);
            return 2;
        }
        finally
        {
            Out.Flush();
        }
    }

    static int Run(string mode, string argument, string[] arguments)
    {
        if (mode == "decode") return Decode();
        if (mode == "assemble") return Assemble();
        if (mode == "session") return FollowSteps();
        if (mode == "source") return ReadSources();
        if (mode == "live") return Live(argument);
        if (mode == "recording") return Recording(argument, arguments.Length > 2);
        if (mode == "lease") return ReadLeases();
        if (mode == "allocations") return argument.Length == 0 ? OfMemory() : OfSource(argument, int.Parse(arguments[2]));
        if (mode == "ring") return Ring();
        if (mode == "geometry") return Geometry();
        if (mode == "dns") return Dns();
        if (mode == "find") return Find(argument);
        throw new ArgumentException("unknown mode " + mode);
    }

    static IEnumerable<string> Lines()
    {
        string line;
        while ((line = Console.In.ReadLine()) != null) yield return line;
    }

    static double Parse(string number) => double.Parse(number, CultureInfo.InvariantCulture);

    static byte[] Bytes(string hex)
    {
        var bytes = new byte[hex.Length / 2];
        for (var i = 0; i < bytes.Length; i++) bytes[i] = Convert.ToByte(hex.Substring(2 * i, 2), 16);
        return bytes;
    }

    static string Hex(byte[] bytes, int length) => BitConverter.ToString(bytes, 0, length).Replace("-", "").ToLowerInvariant();

    static string List(List<string> items) => "[" + string.Join(", ", items) + "]";

    static List<string> Views(EventQueue events)
    {
        var views = new List<string>();
        for (var i = 0; i < events.Count; i++) views.Add(View.Event(events[i]));
        return views;
    }

    // Each line is a datagram; the result is its content, or null if it is refused.
    static int Decode()
    {
        var reader = new DatagramReader();
        var datagram = new Datagram();
        foreach (var line in Lines())
        {
            var bytes = Bytes(line);
            var items = new List<string>();
            var error = reader.Read(bytes, bytes.Length, datagram);
            for (var i = 0; i < datagram.Items.Count; i++) items.Add(View.Item(datagram.Items.Items[i]));
            Out.WriteLine(error == null ? List(items) : "null");
        }
        return 0;
    }

    // Each line is `SECONDS HEX`, or `SECONDS -`; an empty line starts again.
    static int Assemble()
    {
        var assembler = new Assembler();
        var events = new EventQueue();
        foreach (var line in Lines())
        {
            if (line.Length == 0)
            {
                assembler = new Assembler();
                continue;
            }
            var words = line.Split(' ');
            events.Clear();
            string error = null;
            if (words[1] == "-") assembler.Expire(Parse(words[0]), events);
            else
            {
                var bytes = Bytes(words[1]);
                error = assembler.Receive(bytes, bytes.Length, Parse(words[0]), events);
            }
            Out.WriteLine(error == null ? List(Views(events)) : "null");
        }
        return 0;
    }

    // The first line is `NODE SURFACE EVERYTHING` (`*`: any), the others are steps.
    static int FollowSteps()
    {
        var follow = Console.In.ReadLine().Replace("*", "").Split(' ');
        var session = new Session(new Follow(follow[0], follow[1], follow[2] == "all"), new Printer(true));
        foreach (var line in Lines())
        {
            var words = line.Split(' ');
            if (words[1] == "-") session.Expire(Parse(words[0]));
            else session.Receive(Bytes(words[1]), words[1].Length / 2, Parse(words[0]));
        }
        Out.WriteLine("{\"bad\": " + session.Bad + ", \"foreign\": " + session.Foreign + "}");
        return 0;
    }

    // Prints events, and the touches of each frame after it.
    sealed class Printer : ISessionListener
    {
        readonly bool _touches;

        public int Lost { get; private set; }

        public Printer(bool touches)
        {
            _touches = touches;
        }

        public void OnEvent(SessionEvent found)
        {
            Out.WriteLine(View.Event(found));
            if (found.Kind == EventKind.Lost) Lost++;
            if (!_touches || found.Kind != EventKind.Frame) return;
            foreach (var contact in found.Frame.Contacts) Print(contact.IsUp ? "up" : "down", found.Frame, contact.Id, contact.Contacts);
            foreach (var pointer in found.Frame.Pointers)
                if (found.Frame.IsMoving(pointer)) Print("move", found.Frame, pointer.Id, pointer.Contacts);
        }

        static void Print(string kind, HaloFrame frame, int id, int contacts)
        {
            var key = string.Join("/", frame.Node, frame.Surface, frame.Session, id, contacts);
            Out.WriteLine("{\"kind\": \"" + kind + "\", \"key\": \"" + key + "\"}");
        }
    }

    static int ReadSources()
    {
        foreach (var line in Lines())
        {
            try
            {
                var s = Source.Parse(line);
                Out.WriteLine(string.Join(" ", s.Kind, s.Host + ":" + s.Port, s.HelloHost + ":" + s.HelloPort, s.Stream, s.Url + s.Path, s.Follow.Node + "/" + s.Follow.Surface, s.Follow.Everything));
            }
            catch (InputException error)
            {
                Out.WriteLine("refused: " + error.Message);
            }
        }
        return 0;
    }

    // Prints what arrives until the standard input ends.
    static int Live(string url)
    {
        var over = false;
        new Thread(() => { Console.In.ReadToEnd(); over = true; }) { IsBackground = true }.Start();
        using (var client = Client.Open(url, new Printer(false)))
        {
            Console.Error.WriteLine("ready");
            while (!Volatile.Read(ref over))
            {
                client.Poll();
                Out.Flush();
                Thread.Sleep(4);
            }
        }
        Out.Flush();
        return 0;
    }

    // To its end, or two rounds of a loop.
    static int Recording(string path, bool loop)
    {
        var printer = new Printer(false);
        using (var client = loop ? Client.OpenRecording(File.ReadAllText(path), path, true, printer) : Client.Open(path, printer))
        {
            var until = Clock.NowS + 20;
            while (!client.IsEnded && printer.Lost < 2 && Clock.NowS < until)
            {
                client.Poll();
                Thread.Sleep(2);
            }
            if (client.Problem.Length > 0) Console.Error.WriteLine(client.Problem);
        }
        return 0;
    }

    // For each answer (`SECONDS HEX`, or `SECONDS -`) the state and what is due; an empty line starts again.
    static int ReadLeases()
    {
        var lease = new Lease("frames", 0);
        foreach (var line in Lines())
        {
            if (line.Length == 0)
            {
                lease = new Lease("frames", 0);
                continue;
            }
            var words = line.Split(' ');
            if (words[1] != "-") lease.Handle(Bytes(words[1]), words[1].Length / 2);
            var due = lease.Due(Parse(words[0]));
            Out.WriteLine(lease.State + " " + (due == null ? "-" : Hex(due.Bytes, due.Length)) + " " + lease.Reason);
        }
        var goodbye = lease.Goodbye();
        Out.WriteLine(goodbye == null ? "-" : Hex(goodbye.Bytes, goodbye.Length));
        return 0;
    }
}
