using System;
using System.Collections.Generic;
using HaloTouch;
using HaloTouch.Internal;

// Geometry and discovery.
static partial class Program
{
    static string Numbers(params float[] numbers)
    {
        var texts = new List<string>();
        foreach (var number in numbers) texts.Add(View.Number(number));
        return List(texts);
    }

    static float[] Floats(string[] words)
    {
        var numbers = new float[words.Length - 1];
        for (var i = 1; i < words.Length; i++) numbers[i - 1] = (float)Parse(words[i]);
        return numbers;
    }

    static HaloMatrix33 Matrix(float[] n, int at, int step) =>
        new HaloMatrix33(
            n[at], n[at + 1], n[at + 2], n[at + step], n[at + step + 1], n[at + step + 2],
            n[at + 2 * step], n[at + 2 * step + 1], n[at + 2 * step + 2]);

    static string Numbers(Metres p) => Numbers(p.X, p.Y, p.Z);

    // `local X Y HOVER W H`, `marker W H M(12)`, `projector WMM HMM WPX HPX DISTANCE M(9)`.
    static int Geometry()
    {
        foreach (var line in Lines())
        {
            var words = line.Split(' ');
            var n = Floats(words);
            if (words[0] == "local") Out.WriteLine(Numbers(SurfaceSpace.ToLocal(n[0], n[1], n[2], n[3], n[4])));
            else if (words[0] == "marker")
            {
                var pose = new HaloMatrix34(Matrix(n, 2, 4), n[5], n[9], n[13]);
                var place = SurfaceSpace.InMarker(in pose, n[0], n[1]);
                Out.WriteLine("[" + Numbers(place.Position) + ", " + Numbers(place.Up) + ", " + Numbers(place.Forward) + "]");
            }
            else
            {
                var rows = new float[16];
                var found = new HaloHomography("desk", "s1", 0, (int)n[2], (int)n[3], Matrix(n, 5, 3));
                Out.WriteLine(ProjectorMatrix.Fill(in found, n[0], n[1], n[4], rows) ? Numbers(rows) : "null");
            }
        }
        return 0;
    }

    static string Names(List<FoundService> services)
    {
        var texts = new List<string>();
        foreach (var each in services)
            texts.Add("{" + View.Text("node", each.Node).Substring(2) + View.Text("surface", each.Surface) +
                View.Text("source", each.Source) + "}");
        return List(texts);
    }

    static int Dns()
    {
        foreach (var line in Lines())
        {
            try
            {
                var bytes = Bytes(line);
                var count = DnsReader.Read(bytes, bytes.Length, "192.0.2.1").Count;
                Out.WriteLine(count.ToString());
            }
            catch (Exception error)
            {
                Out.WriteLine(error.GetType().Name);
            }
        }
        Out.WriteLine(Hex(DnsReader.Question(), DnsReader.Question().Length));
        return 0;
    }

    static int Find(string seconds)
    {
        Out.WriteLine(Names(ServiceFinder.Find(Parse(seconds))));
        return 0;
    }
}
