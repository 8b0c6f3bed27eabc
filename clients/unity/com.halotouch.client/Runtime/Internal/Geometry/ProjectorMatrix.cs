namespace HaloTouch.Internal
{
    // The projection of a camera above the surface for the projector's picture: each point of the
    // surface is drawn on the pixel that lights it. What is above or below the surface is drawn
    // straight down onto it.
    static class ProjectorMatrix
    {
        // Fills 16 numbers, row by row. The camera is `distanceM` above the middle of the surface and
        // looks down, its top is the far edge. False if the homography is degenerate.
        public static bool Fill(
            in HaloHomography found, float widthMm, float heightMm, float distanceM, float[] rows)
        {
            var h = found.ProjectorFromSurface;
            var x = new Row(h.M00, h.M01, h.M02, widthMm, heightMm);
            var y = new Row(h.M10, h.M11, h.M12, widthMm, heightMm);
            var w = new Row(h.M20, h.M21, h.M22, widthMm, heightMm);
            if (!(w.Middle * w.Middle > 0)) return false;
            var scale = 1 / w.Middle; // 1 in the middle, so that w is positive over the surface
            Set(rows, 0, Row.Sum(x, 2f / found.WidthPx, w, -1), scale);
            Set(rows, 4, Row.Sum(w, 1, y, -2f / found.HeightPx), scale);
            rows[8] = rows[9] = 0;
            rows[10] = -1 / distanceM; // nearer is higher
            rows[11] = -1;
            Set(rows, 12, w, scale);
            return true;
        }

        static void Set(float[] rows, int at, Row row, float scale)
        {
            rows[at] = row.Right * scale;
            rows[at + 1] = row.Far * scale;
            rows[at + 2] = 0;
            rows[at + 3] = row.Middle * scale;
        }

        // A row of the homography over metres to the right and to the far edge of the middle.
        readonly struct Row
        {
            public readonly float Right;
            public readonly float Far;
            public readonly float Middle;

            public Row(float x, float y, float one, float widthMm, float heightMm)
            {
                Right = 1000 * x;
                Far = -1000 * y;
                Middle = x * widthMm / 2 + y * heightMm / 2 + one;
            }

            Row(float right, float far, float middle)
            {
                Right = right;
                Far = far;
                Middle = middle;
            }

            public static Row Sum(Row a, float ofA, Row b, float ofB) =>
                new Row(
                    a.Right * ofA + b.Right * ofB, a.Far * ofA + b.Far * ofB,
                    a.Middle * ofA + b.Middle * ofB);
        }
    }
}
