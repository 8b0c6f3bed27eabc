namespace HaloTouch.Internal
{
    // A position in metres, left-handed as in Unity.
    readonly struct Metres
    {
        public readonly float X;
        public readonly float Y;
        public readonly float Z;

        public Metres(float x, float y, float z)
        {
            X = x;
            Y = y;
            Z = z;
        }
    }

    // Where something is: its origin, and the directions of its y and z axes.
    readonly struct Placement
    {
        public readonly Metres Position;
        public readonly Metres Up;
        public readonly Metres Forward;

        public Placement(Metres position, Metres up, Metres forward)
        {
            Position = position;
            Up = up;
            Forward = forward;
        }
    }

    // From the wire's frames (mm, right-handed: x right, y towards the user, z into the surface) to
    // Unity's (m, left-handed: x right, y up from the surface, z towards the far edge). The origin of
    // the surface in Unity is its middle, so that it stays in place when its size arrives.
    static class SurfaceSpace
    {
        const float MetresPerMm = 0.001f;

        public static Metres ToLocal(float xMm, float yMm, float hoverMm, float widthMm, float heightMm) =>
            new Metres(
                (xMm - widthMm / 2) * MetresPerMm, hoverMm * MetresPerMm, (heightMm / 2 - yMm) * MetresPerMm);

        // The surface as seen from a printed marker. The marker's axes in Unity are x to its right,
        // y up from the paper and z to its top.
        public static Placement InMarker(in HaloMatrix34 anchorFromSurface, float widthMm, float heightMm)
        {
            var r = anchorFromSurface.Rotation;
            float x = widthMm / 2, y = heightMm / 2; // the middle in the surface's frame
            var position = Flip(
                r.M00 * x + r.M01 * y + anchorFromSurface.XMm, r.M10 * x + r.M11 * y + anchorFromSurface.YMm,
                r.M20 * x + r.M21 * y + anchorFromSurface.ZMm, MetresPerMm);
            // Up is -z of the surface's frame, forward is -y.
            return new Placement(position, Flip(r.M02, r.M12, r.M22, -1), Flip(r.M01, r.M11, r.M21, -1));
        }

        static Metres Flip(float x, float y, float z, float scale) =>
            new Metres(x * scale, -z * scale, -y * scale);
    }
}
