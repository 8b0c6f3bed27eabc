// Signatures of UnityEditor, written by hand from Unity's public scripting reference (2022.3). See
// UnityEngine.cs.
using System;
using UnityEngine;

namespace UnityEditor
{
    public class ScriptableObjectOfEditor : UnityEngine.Object
    {
    }

    public class EditorWindow : ScriptableObjectOfEditor
    {
        public static T GetWindow<T>(string title) where T : EditorWindow => throw null;
        public void Repaint() => throw null;
    }

    public enum PlayModeStateChange { EnteredEditMode, ExitingEditMode, EnteredPlayMode, ExitingPlayMode }

    public static class EditorApplication
    {
        public delegate void CallbackFunction();
        public static CallbackFunction update;
        public static event Action<PlayModeStateChange> playModeStateChanged
        {
            add => throw null;
            remove => throw null;
        }
    }

    public static class Selection
    {
        public static GameObject activeGameObject { get; set; }
    }

    public static class Undo
    {
        public static void RegisterCreatedObjectUndo(UnityEngine.Object objectToUndo, string name) => throw null;
        public static void RecordObject(UnityEngine.Object objectToUndo, string name) => throw null;
    }

    public static class EditorUtility
    {
        public static void SetDirty(UnityEngine.Object target) => throw null;
    }

    [AttributeUsage(AttributeTargets.Method, AllowMultiple = true)]
    public sealed class MenuItem : Attribute
    {
        public MenuItem(string itemName) => throw null;
        public MenuItem(string itemName, bool isValidateFunction, int priority) => throw null;
    }

    public enum MessageType { None, Info, Warning, Error }

    public static class EditorStyles
    {
        public static GUIStyle boldLabel { get; }
    }

    public static class EditorGUI
    {
        public static void BeginDisabledGroup(bool disabled) => throw null;
        public static void EndDisabledGroup() => throw null;
    }

    public static class EditorGUILayout
    {
        public static Vector2 BeginScrollView(Vector2 scrollPosition, params GUILayoutOption[] options) => throw null;
        public static void EndScrollView() => throw null;
        public static void Space() => throw null;
        public static void LabelField(string label, params GUILayoutOption[] options) => throw null;
        public static void LabelField(string label, GUIStyle style, params GUILayoutOption[] options) => throw null;
        public static void LabelField(string label, string label2, params GUILayoutOption[] options) => throw null;
        public static string TextField(string label, string text, params GUILayoutOption[] options) => throw null;
        public static void HelpBox(string message, MessageType type) => throw null;
        public static Rect BeginHorizontal(params GUILayoutOption[] options) => throw null;
        public static void EndHorizontal() => throw null;
    }
}

namespace UnityEngine
{
    public struct Rect
    {
    }
}

namespace UnityEditor.AssetImporters
{
    [AttributeUsage(AttributeTargets.Class)]
    public class ScriptedImporterAttribute : Attribute
    {
        public ScriptedImporterAttribute(int version, string ext) => throw null;
    }

    public abstract class ScriptedImporter : UnityEngine.Object
    {
        public abstract void OnImportAsset(AssetImportContext ctx);
    }

    public class AssetImportContext
    {
        public string assetPath { get; }
        public void AddObjectToAsset(string identifier, UnityEngine.Object obj) => throw null;
        public void SetMainObject(UnityEngine.Object obj) => throw null;
    }
}
