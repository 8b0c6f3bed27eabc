using UnityEditor;
using UnityEngine;

namespace HaloTouch.Editor
{
    // Adds receiver, surface and projector camera to the scene, each once. Undo removes them.
    static class SceneSetup
    {
        [MenuItem("GameObject/Halo Touch/Receiver and Surface", false, 10)]
        static void AddFromMenu()
        {
            Selection.activeGameObject = AddSurface(null).gameObject;
        }

        [MenuItem("GameObject/Halo Touch/Projector Camera", false, 11)]
        static void AddCameraFromMenu()
        {
            Selection.activeGameObject = AddProjectorCamera().gameObject;
        }

        // The receiver of the scene, with a source if one is given.
        public static HaloReceiver AddReceiver(string source)
        {
            var receiver = Object.FindFirstObjectByType<HaloReceiver>();
            if (receiver == null) receiver = Add<HaloReceiver>("Halo Receiver");
            if (source == null) return receiver;
            Undo.RecordObject(receiver, "Set Halo Source");
            receiver.Source = source;
            EditorUtility.SetDirty(receiver);
            return receiver;
        }

        public static HaloSurface AddSurface(string source)
        {
            var receiver = AddReceiver(source);
            var surface = Object.FindFirstObjectByType<HaloSurface>();
            if (surface == null) surface = Add<HaloSurface>("Halo Surface");
            if (surface.Receiver != null) return surface;
            Undo.RecordObject(surface, "Set Halo Receiver");
            surface.Receiver = receiver;
            EditorUtility.SetDirty(surface);
            return surface;
        }

        // A camera for the projector's picture.
        public static HaloProjectorCamera AddProjectorCamera()
        {
            var surface = AddSurface(null);
            var projector = Object.FindFirstObjectByType<HaloProjectorCamera>();
            if (projector != null) return projector;
            projector = Add<HaloProjectorCamera>("Halo Projector Camera");
            var camera = projector.GetComponent<Camera>();
            camera.clearFlags = CameraClearFlags.SolidColor;
            camera.backgroundColor = Color.black; // no light where nothing is drawn
            camera.nearClipPlane = 0.1f;
            camera.farClipPlane = 5;
            projector.Surface = surface;
            return projector;
        }

        static T Add<T>(string name) where T : Component
        {
            var added = new GameObject(name);
            Undo.RegisterCreatedObjectUndo(added, "Add " + name);
            return added.AddComponent<T>();
        }
    }
}
