// Stand-ins for UnityEngine, written by hand from Unity's public scripting reference (2022.3), only what the
// package uses. mcs checks types and names with them. A few have the documented behaviour, so that a test can
// run the components; the others throw. They are not Unity: how Unity itself behaves is not tested.
using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public class Object
    {
        public string name { get; set; }
        public static implicit operator bool(Object exists) => !ReferenceEquals(exists, null);
        public static bool operator ==(Object x, Object y) => ReferenceEquals(x, y);
        public static bool operator !=(Object x, Object y) => !ReferenceEquals(x, y);
        public override bool Equals(object other) => ReferenceEquals(this, other);
        public override int GetHashCode() => base.GetHashCode();
        public static void Destroy(Object obj) => throw null;
        public static T FindFirstObjectByType<T>() where T : Object => throw null;
    }

    public class Component : Object
    {
        public Transform transform => gameObject.transform;
        public GameObject gameObject { get; internal set; }
        public T GetComponent<T>() => gameObject.GetComponent<T>();
    }

    public class Behaviour : Component
    {
        public bool enabled { get; set; }
        public bool isActiveAndEnabled => true;
    }

    public class MonoBehaviour : Behaviour
    {
    }

    public sealed class GameObject : Object
    {
        readonly List<Component> _components = new List<Component>();

        public GameObject(string name)
        {
            this.name = name;
            transform = AddComponent<Transform>();
        }

        public Transform transform { get; }

        public T AddComponent<T>() where T : Component
        {
            var added = Activator.CreateInstance<T>();
            added.gameObject = this;
            _components.Add(added);
            return added;
        }

        public T GetComponent<T>()
        {
            foreach (object each in _components)
                if (each is T) return (T)each;
            return default(T);
        }

        public void SetActive(bool value) => throw null;
        public static GameObject CreatePrimitive(PrimitiveType type) => throw null;
    }

    public enum PrimitiveType { Sphere, Capsule, Cylinder, Cube, Plane, Quad }

    public class Transform : Component
    {
        public Vector3 position { get; set; }
        public Quaternion rotation { get; set; } = new Quaternion(0, 0, 0, 1);
        public Vector3 localScale { get; set; } = Vector3.one;
        public Vector3 up => rotation * new Vector3(0, 1, 0);
        public Vector3 forward => rotation * new Vector3(0, 0, 1);
        public Vector3 right => rotation * new Vector3(1, 0, 0);
        public Vector3 TransformPoint(Vector3 position) => this.position + TransformVector(position);

        public Vector3 TransformVector(Vector3 vector) =>
            rotation * new Vector3(vector.x * localScale.x, vector.y * localScale.y, vector.z * localScale.z);

        public void SetPositionAndRotation(Vector3 position, Quaternion rotation)
        {
            this.position = position;
            this.rotation = rotation;
        }

        public void SetParent(Transform p) => throw null;
    }

    public struct Vector2
    {
        public float x, y;

        public Vector2(float x, float y)
        {
            this.x = x;
            this.y = y;
        }

        public static Vector2 operator /(Vector2 a, float d) => new Vector2(a.x / d, a.y / d);
    }

    public struct Vector3
    {
        public float x, y, z;

        public Vector3(float x, float y, float z)
        {
            this.x = x;
            this.y = y;
            this.z = z;
        }

        public static Vector3 one => new Vector3(1, 1, 1);
        public static Vector3 Cross(Vector3 a, Vector3 b) =>
            new Vector3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
        public static float Dot(Vector3 a, Vector3 b) => a.x * b.x + a.y * b.y + a.z * b.z;
        public Vector3 normalized => this / (float)Math.Sqrt(Dot(this, this));
        public static Vector3 operator +(Vector3 a, Vector3 b) => new Vector3(a.x + b.x, a.y + b.y, a.z + b.z);
        public static Vector3 operator -(Vector3 a, Vector3 b) => a + -b;
        public static Vector3 operator -(Vector3 a) => new Vector3(-a.x, -a.y, -a.z);
        public static Vector3 operator *(Vector3 a, float d) => new Vector3(a.x * d, a.y * d, a.z * d);
        public static Vector3 operator *(float d, Vector3 a) => a * d;
        public static Vector3 operator /(Vector3 a, float d) => a * (1 / d);
    }

    public struct Quaternion
    {
        public float x, y, z, w;

        public Quaternion(float x, float y, float z, float w)
        {
            this.x = x;
            this.y = y;
            this.z = z;
            this.w = w;
        }

        // z along forward, y as near to upwards as possible.
        public static Quaternion LookRotation(Vector3 forward, Vector3 upwards)
        {
            var f = forward.normalized;
            var r = Vector3.Cross(upwards, f).normalized;
            var u = Vector3.Cross(f, r);
            // The largest of the four divides the others.
            float ww = 1 + r.x + u.y + f.z, xx = 1 + r.x - u.y - f.z, yy = 1 - r.x + u.y - f.z, zz = 1 - r.x - u.y + f.z;
            float a = u.z - f.y, b = f.x - r.z, c = r.y - u.x, d = r.y + u.x, e = f.x + r.z, g = u.z + f.y;
            var most = Math.Max(Math.Max(ww, xx), Math.Max(yy, zz));
            var half = 0.5f / (float)Math.Sqrt(most);
            if (most == ww) return new Quaternion(a * half, b * half, c * half, ww * half);
            if (most == xx) return new Quaternion(xx * half, d * half, e * half, a * half);
            if (most == yy) return new Quaternion(d * half, yy * half, g * half, b * half);
            return new Quaternion(e * half, g * half, zz * half, c * half);
        }

        public static Quaternion operator *(Quaternion l, Quaternion r) =>
            new Quaternion(
                l.w * r.x + l.x * r.w + l.y * r.z - l.z * r.y, l.w * r.y + l.y * r.w + l.z * r.x - l.x * r.z,
                l.w * r.z + l.z * r.w + l.x * r.y - l.y * r.x, l.w * r.w - l.x * r.x - l.y * r.y - l.z * r.z);

        public static Vector3 operator *(Quaternion rotation, Vector3 point)
        {
            var v = new Vector3(rotation.x, rotation.y, rotation.z);
            var t = 2 * Vector3.Cross(v, point);
            return point + rotation.w * t + Vector3.Cross(v, t);
        }
    }

    public struct Matrix4x4
    {
        float[] _rows;

        public float this[int row, int column]
        {
            get => _rows == null ? 0 : _rows[4 * row + column];
            set => (_rows = _rows ?? new float[16])[4 * row + column] = value;
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
        public static float Max(float a, float b) => Math.Max(a, b);
        public static float Sin(float f) => throw null;
        public static float Exp(float power) => throw null;
        public static float Lerp(float a, float b, float t) => throw null;
        public static float Clamp01(float value) => throw null;
        public static int Clamp(int value, int min, int max) => throw null;
    }

    public static class Screen
    {
        public static int width => 1280;
        public static int height => 800;
    }

    public static class Application
    {
        public static bool isPlaying { get; }
    }

    public static class Debug
    {
        public static void LogError(object message, Object context) => Console.Error.WriteLine(message);
        public static void LogException(Exception exception, Object context) => Console.Error.WriteLine(exception.Message);
        public static void LogWarning(object message, Object context) => Console.Error.WriteLine(message);
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
        public void ResetProjectionMatrix()
        {
        }

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
        public TextAsset(string text)
        {
            this.text = text;
        }

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
        public TooltipAttribute(string tooltip)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class AddComponentMenu : Attribute
    {
        public AddComponentMenu(string menuName)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Class)]
    public sealed class DefaultExecutionOrder : Attribute
    {
        public DefaultExecutionOrder(int order)
        {
        }
    }

    [AttributeUsage(AttributeTargets.Class, AllowMultiple = true)]
    public sealed class RequireComponent : Attribute
    {
        public RequireComponent(Type requiredComponent)
        {
        }
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
        event Action<T0> Called;
        public void AddListener(Action<T0> call) => Called += call;
        public void Invoke(T0 arg0) => Called?.Invoke(arg0);
    }
}
