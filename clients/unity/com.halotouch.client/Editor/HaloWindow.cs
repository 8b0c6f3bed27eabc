using System.Collections.Generic;
using System.Threading;
using HaloTouch.Internal;
using UnityEditor;
using UnityEngine;

namespace HaloTouch.Editor
{
    // What the service sends, services on the network, and the set-up of the scene.
    sealed class HaloWindow : EditorWindow
    {
        const double FindS = 2;

        List<FoundService> _services = new List<FoundService>();
        volatile List<FoundService> _found; // of the searching thread, until the window shows it
        Thread _search;
        Vector2 _scroll;
        Preview _preview;
        string _source = "osc://127.0.0.1:4256";

        [MenuItem("Window/Halo Touch")]
        static void Open()
        {
            GetWindow<HaloWindow>("Halo Touch");
        }

        void OnEnable()
        {
            EditorApplication.update += Tick;
            EditorApplication.playModeStateChanged += OnPlayModeChanged;
        }

        void OnDisable()
        {
            EditorApplication.update -= Tick;
            EditorApplication.playModeStateChanged -= OnPlayModeChanged;
            StopPreview();
        }

        // The preview would hold the port that the scene's receiver needs.
        void OnPlayModeChanged(PlayModeStateChange change)
        {
            StopPreview();
        }

        void Tick()
        {
            if (_found != null)
            {
                _services = _found;
                _found = null;
                _search = null;
                Repaint();
            }
            if (_preview != null) _preview.Poll();
            if (_preview != null || Application.isPlaying) Repaint();
        }

        void StopPreview()
        {
            if (_preview != null) _preview.Dispose();
            _preview = null;
        }

        void OnGUI()
        {
            _scroll = EditorGUILayout.BeginScrollView(_scroll);
            ShowServices();
            EditorGUILayout.Space();
            ShowScene();
            EditorGUILayout.Space();
            ShowState();
            EditorGUILayout.EndScrollView();
        }

        void ShowServices()
        {
            EditorGUILayout.LabelField("Services", EditorStyles.boldLabel);
            EditorGUI.BeginDisabledGroup(_search != null);
            if (GUILayout.Button(_search == null ? "Find services" : "Looking...")) StartSearch();
            EditorGUI.EndDisabledGroup();
            foreach (var service in _services)
            {
                EditorGUILayout.BeginHorizontal();
                EditorGUILayout.LabelField(service.Node + " (" + service.Surface + ") at " + service.Host);
                if (GUILayout.Button("Use", GUILayout.Width(60))) Use(service);
                EditorGUILayout.EndHorizontal();
            }
        }

        void StartSearch()
        {
            _search = new Thread(() => _found = ServiceFinder.Find(FindS)) { IsBackground = true };
            _search.Start();
        }

        void Use(FoundService service)
        {
            _source = service.Source;
            StopPreview();
            SceneSetup.AddReceiver(service.Source);
        }

        static void ShowScene()
        {
            EditorGUILayout.LabelField("Scene", EditorStyles.boldLabel);
            if (GUILayout.Button("Add receiver and surface")) SceneSetup.AddSurface(null);
            if (GUILayout.Button("Set up projector camera")) SceneSetup.AddProjectorCamera();
        }

        void ShowState()
        {
            EditorGUILayout.LabelField("Live state", EditorStyles.boldLabel);
            if (Application.isPlaying)
            {
                var receiver = Object.FindFirstObjectByType<HaloReceiver>();
                if (receiver == null) EditorGUILayout.LabelField("no receiver in the scene");
                else StateView.Show(receiver);
                return;
            }
            _source = EditorGUILayout.TextField("Source", _source);
            if (_preview == null && GUILayout.Button("Listen")) _preview = Preview.Open(_source);
            else if (_preview != null && GUILayout.Button("Stop")) StopPreview();
            if (_preview != null) _preview.Show();
        }
    }
}
