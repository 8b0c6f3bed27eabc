// Signatures of UnityEngine, written by hand from Unity's public scripting reference (2022.3), only those
// that the package uses. They let mcs check types and names. They do nothing: no test runs them.
using System;

namespace UnityEngine
{
    public class Object
    {
        public string name { get; set; }
        public static implicit operator bool(Object exists) => throw null;
        public static bool operator ==(Object x, Object y) => throw null;
        public static bool operator !=(Object x, Object y) => throw null;
        public override bool Equals(object other) => throw null;
        public override int GetHashCode() => throw null;
        public static void Destroy(Object obj) => throw null;
        public static T FindFirstObjectByType<T>() where T : Object => throw null;
    }

    public class Component : Object
    {
        public Transform transform { get; }
        public GameObject gameObject { get; }
        public T GetComponent<T>() => throw null;
    }

    public class Behaviour : Component
    {
        public bool enabled { get; set; }
        public bool isActiveAndEnabled { get; }
    }

    public class MonoBehaviour : Behaviour
    {
    }

    public sealed class GameObject : Object
    {
        public GameObject(string name) => throw null;
        public Transform transform { get; }
        public T AddComponent<T>() where T : Component => throw null;
        public T GetComponent<T>() => throw null;
        public void SetActive(bool value) => throw null;
        public static GameObject CreatePrimitive(PrimitiveType type) => throw null;
    }

    public enum PrimitiveType { Sphere, Capsule, Cylinder, Cube, Plane, Quad }

    public class Transform : Component
    {
        public Vector3 position { get; set; }
        public Quaternion rotation { get; set; }
        public Vector3 localScale { get; set; }
        public Vector3 up { get; set; }
        public Vector3 forward { get; set; }
        public Vector3 TransformPoint(Vector3 position) => throw null;
        public Vector3 TransformVector(Vector3 vector) => throw null;
        public void SetPositionAndRotation(Vector3 position, Quaternion rotation) => throw null;
        public void SetParent(Transform p) => throw null;
    }

    public struct Vector2
    {
        public float x, y;
        public Vector2(float x, float y) => throw null;
        public static Vector2 operator /(Vector2 a, float d) => throw null;
    }

    public struct Vector3
    {
        public float x, y, z;
        public Vector3(float x, float y, float z) => throw null;
        public static Vector3 one { get; }
        public static Vector3 operator +(Vector3 a, Vector3 b) => throw null;
        public static Vector3 operator -(Vector3 a) => throw null;
        public static Vector3 operator *(Vector3 a, float d) => throw null;
        public static Vector3 operator *(float d, Vector3 a) => throw null;
        public static Vector3 operator /(Vector3 a, float d) => throw null;
    }

    public struct Quaternion
    {
        public static Quaternion LookRotation(Vector3 forward, Vector3 upwards) => throw null;
        public static Quaternion operator *(Quaternion lhs, Quaternion rhs) => throw null;
        public static Vector3 operator *(Quaternion rotation, Vector3 point) => throw null;
    }

    public struct Matrix4x4
    {
        public float this[int row, int column]
        {
            get => throw null;
            set => throw null;
        }
    }

    public struct Color
    {
        public static Color black { get; }
        public static Color cyan { get; }
        public static Color red { get; }
        public static Color yellow { get; }
        public static Color HSVToRGB(float H, float S, float V) => throw null;
    }

    public static class Mathf
    {
        public const float PI = (float)Math.PI;
        public static float Max(float a, float b) => throw null;
        public static float Sin(float f) => throw null;
        public static float Exp(float power) => throw null;
        public static float Lerp(float a, float b, float t) => throw null;
        public static float Clamp01(float value) => throw null;
        public static int Clamp(int value, int min, int max) => throw null;
    }

    public static class Screen
    {
        public static int width { get; }
        public static int height { get; }
    }

    public static class Application
    {
        public static bool isPlaying { get; }
    }

    public static class Debug
    {
        public static void LogError(object message, Object context) => throw null;
        public static void LogException(Exception exception, Object context) => throw null;
        public static void LogWarning(object message, Object context) => throw null;
    }

    public static class Gizmos
    {
        public static Color color { get; set; }
        public static void DrawLine(Vector3 from, Vector3 to) => throw null;
        public static void DrawWireSphere(Vector3 center, float radius) => throw null;
    }

    public enum CameraClearFlags { Skybox = 1, Color = 2, SolidColor = 2, Depth = 3, Nothing = 4 }

    public sealed class Camera : Behaviour
    {
        public Matrix4x4 projectionMatrix { get; set; }
        public void ResetProjectionMatrix() => throw null;
        public bool orthographic { get; set; }
        public float orthographicSize { get; set; }
        public float aspect { get; set; }
        public float nearClipPlane { get; set; }
        public float farClipPlane { get; set; }
        public CameraClearFlags clearFlags { get; set; }
        public Color backgroundColor { get; set; }
    }

    public class TextAsset : Object
    {
        public TextAsset(string text) => throw null;
        public string text { get; }
    }

    public class Shader : Object
    {
        public static Shader Find(string name) => throw null;
    }

    public class Material : Object
    {
        public Material(Shader shader) => throw null;
        public Color color { get; set; }
    }

    public class Renderer : Component
    {
        public Material material { get; set; }
    }

    public sealed class LineRenderer : Renderer
    {
        public Color startColor { get; set; }
        public Color endColor { get; set; }
        public int positionCount { get; set; }
        public float widthMultiplier { get; set; }
        public void SetPosition(int index, Vector3 position) => throw null;
    }

    public sealed class AudioClip : Object
    {
        public static AudioClip Create(string name, int lengthSamples, int channels, int frequency, bool stream) => throw null;
        public bool SetData(float[] data, int offsetSamples) => throw null;
    }

    public sealed class AudioSource : Behaviour
    {
        public AudioClip clip { get; set; }
        public float pitch { get; set; }
        public void PlayOneShot(AudioClip clip, float volumeScale) => throw null;
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class SerializeField : Attribute
    {
    }

    [AttributeUsage(AttributeTargets.Field)]
    public sealed class TooltipAttribute : Attribute
    {
        public TooltipAttribute(string tooltip) => throw null;
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class AddComponentMenu : Attribute
    {
        public AddComponentMenu(string menuName) => throw null;
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class DefaultExecutionOrder : Attribute
    {
        public DefaultExecutionOrder(int order) => throw null;
    }

    [AttributeUsage(AttributeTargets.Class, AllowMultiple = true)]
    public sealed class RequireComponent : Attribute
    {
        public RequireComponent(Type requiredComponent) => throw null;
    }

    public class GUILayoutOption
    {
    }

    public static class GUILayout
    {
        public static bool Button(string text, params GUILayoutOption[] options) => throw null;
        public static GUILayoutOption Width(float width) => throw null;
    }

    public sealed class GUIStyle
    {
    }
}

namespace UnityEngine.Events
{
    public abstract class UnityEventBase
    {
    }

    public class UnityEvent<T0> : UnityEventBase
    {
        public void Invoke(T0 arg0) => throw null;
    }
}
