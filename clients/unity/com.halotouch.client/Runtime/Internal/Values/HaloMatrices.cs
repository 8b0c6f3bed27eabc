namespace HaloTouch
{
    /// <summary>3 x 3 numbers, row by row: a homography.</summary>
    public readonly struct HaloMatrix33
    {
        /// <summary>Row 0.</summary>
        public float M00 { get; }
        /// <summary>Row 0.</summary>
        public float M01 { get; }
        /// <summary>Row 0.</summary>
        public float M02 { get; }
        /// <summary>Row 1.</summary>
        public float M10 { get; }
        /// <summary>Row 1.</summary>
        public float M11 { get; }
        /// <summary>Row 1.</summary>
        public float M12 { get; }
        /// <summary>Row 2.</summary>
        public float M20 { get; }
        /// <summary>Row 2.</summary>
        public float M21 { get; }
        /// <summary>Row 2.</summary>
        public float M22 { get; }

        internal HaloMatrix33(
            float m00, float m01, float m02, float m10, float m11, float m12, float m20, float m21,
            float m22)
        {
            M00 = m00;
            M01 = m01;
            M02 = m02;
            M10 = m10;
            M11 = m11;
            M12 = m12;
            M20 = m20;
            M21 = m21;
            M22 = m22;
        }
    }

    /// <summary>3 x 4 numbers, row by row: a rotation and, in the last column, a shift in mm.</summary>
    public readonly struct HaloMatrix34
    {
        /// <summary>The rotation's columns 0 to 2, as a 3 x 3 matrix.</summary>
        public HaloMatrix33 Rotation { get; }
        /// <summary>The shift along x in mm.</summary>
        public float XMm { get; }
        /// <summary>The shift along y in mm.</summary>
        public float YMm { get; }
        /// <summary>The shift along z in mm.</summary>
        public float ZMm { get; }

        internal HaloMatrix34(HaloMatrix33 rotation, float xMm, float yMm, float zMm)
        {
            Rotation = rotation;
            XMm = xMm;
            YMm = yMm;
            ZMm = zMm;
        }
    }
}
