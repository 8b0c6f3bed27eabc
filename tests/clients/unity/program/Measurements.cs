using System;
using System.Collections.Generic;
using System.Threading;
using HaloTouch;
using HaloTouch.Internal;

// What the core allocates, and how its hand-off is bounded.
static partial class Program
{
    sealed class Counter : ISessionListener
    {
        public int Frames;
        public float Sum;

        public void OnEvent(SessionEvent found)
        {
            if (found.Kind != EventKind.Frame) return;
            Frames++;
            foreach (var pointer in found.Frame.Pointers) Sum += pointer.Pressure;
            foreach (var contact in found.Frame.Contacts) Sum += contact.StrikeMmS;
        }
    }

    // Bytes allocated while frames are read, after a warm-up. The lines of the standard input are
    // datagrams.
    static int OfMemory()
    {
        var datagrams = new List<byte[]>();
        foreach (var line in Lines()) datagrams.Add(Bytes(line));
        var counter = new Counter();
        var session = new Session(default(Follow), counter);
        var half = datagrams.Count / 2;
        for (var i = 0; i < half; i++) session.Receive(datagrams[i], datagrams[i].Length, i * 0.01);
        var frames = counter.Frames;
        var before = GC.GetAllocatedBytesForCurrentThread();
        for (var i = half; i < datagrams.Count; i++) session.Receive(datagrams[i], datagrams[i].Length, i * 0.01);
        var bytes = GC.GetAllocatedBytesForCurrentThread() - before;
        var probe = GC.GetAllocatedBytesForCurrentThread();
        GC.KeepAlive(new byte[1000]);
        probe = GC.GetAllocatedBytesForCurrentThread() - probe;
        Out.WriteLine("{\"frames\": " + (counter.Frames - frames) + ", \"bytes\": " + bytes + ", \"probe\": " + probe + "}");
        return 0;
    }

    // The main thread's own bytes, and the collections of all threads: with a small nursery
    // (MONO_GC_PARAMS) few bytes cause one.
    static int OfSource(string url, int measured)
    {
        var warm = 60 + measured / 4;
        var counter = new Counter();
        RunAll(new Session(default(Follow), counter));
        counter.Frames = 0;
        using (var client = Client.Open(url, counter))
        {
            Console.Error.WriteLine("ready");
            Wait(client, counter, warm);
            GC.Collect();
            var collections = GC.CollectionCount(0);
            var before = GC.GetAllocatedBytesForCurrentThread();
            Wait(client, counter, warm + measured);
            var bytes = GC.GetAllocatedBytesForCurrentThread() - before;
            collections = GC.CollectionCount(0) - collections;
            Out.WriteLine("{\"frames\": " + measured + ", \"bytes\": " + bytes + ", \"collections\": " + collections + "}");
        }
        return 0;
    }

    // Runs each path once with the datagrams of the standard input: mono compiles a method when it
    // is first called, and allocates then.
    static void RunAll(Session session)
    {
        var nowS = 0.0;
        foreach (var line in Lines()) session.Receive(Bytes(line), line.Length / 2, nowS += 0.05);
        session.Expire(nowS + 10);
    }

    static void Wait(Client client, Counter counter, int frames)
    {
        var until = Clock.NowS + 30;
        while (counter.Frames < frames && Clock.NowS < until)
        {
            client.Poll();
            Thread.Sleep(1);
        }
        if (counter.Frames < frames) throw new TimeoutException("only " + counter.Frames + " frames came");
    }

    // A flood while the main thread is busy: the newest datagrams stay.
    static int Ring()
    {
        var ring = new DatagramRing();
        var bytes = new byte[3000];
        for (var i = 0; i < 1000; i++)
        {
            bytes[0] = (byte)(i >> 8);
            bytes[1] = (byte)i;
            ring.Push(bytes, 2 + i % 2900, i);
        }
        var buffer = new byte[16];
        var numbers = new List<string>();
        while (ring.TryPop(ref buffer, out var length, out var receivedS))
            numbers.Add("[" + (buffer[0] << 8 | buffer[1]) + ", " + length + ", " + View.Number(receivedS) + "]");
        Out.WriteLine("{\"dropped\": " + ring.Dropped + ", \"left\": " + List(numbers) + "}");
        return 0;
    }
}
