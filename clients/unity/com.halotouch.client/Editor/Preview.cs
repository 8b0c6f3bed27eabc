using System;
using HaloTouch.Internal;
using UnityEditor;

namespace HaloTouch.Editor
{
    // Listens to a service without play mode.
    sealed class Preview : ISessionListener, IDisposable
    {
        readonly HaloFrame _frame = new HaloFrame();
        Client _client;
        string _problem = "";

        public static Preview Open(string source)
        {
            var preview = new Preview();
            try
            {
                preview._client = Client.Open(source, preview);
            }
            catch (InputException error)
            {
                preview._problem = error.Message;
            }
            return preview;
        }

        public void Poll()
        {
            if (_client != null) _client.Poll();
        }

        public void Dispose()
        {
            if (_client != null) _client.Dispose();
            _client = null;
        }

        void ISessionListener.OnEvent(SessionEvent found)
        {
            if (found.Kind == EventKind.Frame) _frame.CopyFrom(found.Frame);
        }

        public void Show()
        {
            if (_client == null)
            {
                EditorGUILayout.HelpBox(_problem, MessageType.Error);
                return;
            }
            var problem = _client.Session.IsFollowing ? "" : _client.Problem;
            EditorGUILayout.LabelField(problem.Length > 0 ? problem : StateView.Name(_frame));
            StateView.ShowFingers(_frame);
            EditorGUILayout.LabelField("lost " + _client.Session.Missed + ", bad " + _client.Session.Bad);
        }
    }
}
