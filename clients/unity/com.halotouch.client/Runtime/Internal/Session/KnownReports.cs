using System.Collections.Generic;

namespace HaloTouch.Internal
{
    // The latest scene, homography, pose and health of one surface.
    sealed class SurfaceReports
    {
        public string Node;
        public string Surface;
        public HaloScene? Scene;
        public HaloHomography? Homography;
        public HaloPose? Pose;
        public HaloHealth? Health;

        // Homography and pose count only with the scene of their calibration.
        public void RemoveOutdated()
        {
            if (Scene == null) return;
            var scene = Scene.Value;
            if (Homography != null && !IsOf(Homography.Value.Session, Homography.Value.Revision, in scene))
                Homography = null;
            if (Pose != null && !IsOf(Pose.Value.Session, Pose.Value.Revision, in scene)) Pose = null;
        }

        static bool IsOf(string session, int revision, in HaloScene scene) =>
            session == scene.Session && revision == scene.Revision;

        public void Forget(string session)
        {
            if (Scene?.Session == session) Scene = null;
            if (Homography?.Session == session) Homography = null;
            if (Pose?.Session == session) Pose = null;
            if (Health?.Session == session) Health = null;
        }
    }

    // The newest reports of each surface. Bounded: the surface with the oldest report is removed.
    sealed class KnownReports
    {
        const int MaxSurfaces = 64;

        readonly List<SurfaceReports> _surfaces = new List<SurfaceReports>(); // the newest last

        // Those of one surface, or null.
        public SurfaceReports Find(string node, string surface)
        {
            var index = IndexOf(node, surface);
            return index < 0 ? null : _surfaces[index];
        }

        // Those of the surface that reported last, or null.
        public SurfaceReports Newest() => _surfaces.Count == 0 ? null : _surfaces[_surfaces.Count - 1];

        public void Update(SessionEvent report)
        {
            var reports = ToNewest(report.Node, report.Surface);
            if (report.ReportKind == ItemKind.Scene) reports.Scene = report.Scene;
            else if (report.ReportKind == ItemKind.Homography) reports.Homography = report.Homography;
            else if (report.ReportKind == ItemKind.Pose) reports.Pose = report.Pose;
            else reports.Health = report.Health;
            if (report.ReportKind == ItemKind.Scene) reports.RemoveOutdated();
        }

        public void Forget(string node, string surface, string session)
        {
            Find(node, surface)?.Forget(session);
        }

        SurfaceReports ToNewest(string node, string surface)
        {
            var index = IndexOf(node, surface);
            if (index == _surfaces.Count - 1 && index >= 0) return _surfaces[index];
            var reports = index >= 0 ? _surfaces[index] : new SurfaceReports();
            if (index >= 0) _surfaces.RemoveAt(index);
            else if (_surfaces.Count == MaxSurfaces) _surfaces.RemoveAt(0);
            reports.Node = node;
            reports.Surface = surface;
            _surfaces.Add(reports);
            return reports;
        }

        int IndexOf(string node, string surface)
        {
            for (var i = 0; i < _surfaces.Count; i++)
                if (_surfaces[i].Node == node && _surfaces[i].Surface == surface) return i;
            return -1;
        }
    }
}
