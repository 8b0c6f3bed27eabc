using System;
using HaloTouch.Internal;
using UnityEngine;

namespace HaloTouch
{
    /// <summary>
    /// Receives fingers from a halo service, or from a recorded stream. Its events are called in
    /// Update, before the Update of other scripts.
    /// </summary>
    [AddComponentMenu("Halo Touch/Halo Receiver")]
    [DefaultExecutionOrder(-500)]
    public sealed class HaloReceiver : MonoBehaviour
    {
        [SerializeField]
        [Tooltip("osc://127.0.0.1:4256 receives what the service sends; osc://?hello=HOST:4257 asks a " +
            "service; ws://HOST:4258/halo for web pages; FILE.jsonl")]
        string source = "osc://127.0.0.1:4256";

        [SerializeField]
        [Tooltip("A recorded stream (.jsonl). It replaces the source: build scenes without a service")]
        TextAsset recording = null;

        [SerializeField]
        [Tooltip("Start the recording again at its end")]
        bool loop = true;

        readonly HaloFrame _frame = new HaloFrame();
        readonly Handlers<HaloReceiver, HaloFrame> _onFrame = new Handlers<HaloReceiver, HaloFrame>();
        readonly Handlers<HaloFrame, HaloContact> _onDown = new Handlers<HaloFrame, HaloContact>();
        readonly Handlers<HaloFrame, HaloPointer> _onMoved = new Handlers<HaloFrame, HaloPointer>();
        readonly Handlers<HaloFrame, HaloContact> _onUp = new Handlers<HaloFrame, HaloContact>();
        readonly Handlers<HaloReceiver, string> _onLost = new Handlers<HaloReceiver, string>();
        Client _client;
        string _problem = "";

        /// <summary>Each frame of the service that is followed. Valid during the call only.</summary>
        public event Action<HaloReceiver, HaloFrame> FrameReceived
        {
            add => _onFrame.Add(value);
            remove => _onFrame.Remove(value);
        }

        /// <summary>A touch began.</summary>
        public event Action<HaloFrame, HaloContact> Down
        {
            add => _onDown.Add(value);
            remove => _onDown.Remove(value);
        }

        /// <summary>A touch goes on; once a frame.</summary>
        public event Action<HaloFrame, HaloPointer> Moved
        {
            add => _onMoved.Add(value);
            remove => _onMoved.Remove(value);
        }

        /// <summary>A touch ended, or its service is lost.</summary>
        public event Action<HaloFrame, HaloContact> Up
        {
            add => _onUp.Add(value);
            remove => _onUp.Remove(value);
        }

        /// <summary>
        /// The service is silent or was restarted: its fingers are gone. With the name of the service.
        /// </summary>
        public event Action<HaloReceiver, string> Lost
        {
            add => _onLost.Add(value);
            remove => _onLost.Remove(value);
        }

        /// <summary>Where fingers come from, as in the inspector. Setting it opens it.</summary>
        public string Source
        {
            get => source;
            set
            {
                source = value;
                Reopen();
            }
        }

        /// <summary>A recorded stream that replaces the source, or null. Setting it opens it.</summary>
        public TextAsset Recording
        {
            get => recording;
            set
            {
                recording = value;
                Reopen();
            }
        }

        /// <summary>The newest frame; without fingers while there is no service.</summary>
        public HaloFrame Frame => _frame;

        /// <summary>Whether a service is followed now.</summary>
        public bool IsConnected => _client != null && _client.Session.IsFollowing;

        /// <summary>One sentence about the connection.</summary>
        public string Status
        {
            get
            {
                if (_problem.Length > 0) return _problem;
                if (_client == null) return "closed";
                if (IsConnected) return _frame.Node + "/" + _frame.Surface + ", session " + _frame.Session;
                if (_client.Problem.Length > 0) return _client.Problem;
                return _client.IsEnded ? "the recording is over" : "no frames yet: is `halo serve` running?";
            }
        }

        /// <summary>Frames that never arrived.</summary>
        public int MissedFrames => _client == null ? 0 : _client.Session.Missed;

        /// <summary>Datagrams that could not be read, such as those of other programs.</summary>
        public int BadDatagrams => _client == null ? 0 : _client.Session.Bad;

        /// <summary>The scene of the service, with the surface's size; false if it is not known yet.</summary>
        public bool TryGetScene(out HaloScene scene) => TryGet(Reports?.Scene, out scene);

        /// <summary>The projector's homography; false if the service has none.</summary>
        public bool TryGetHomography(out HaloHomography homography) => TryGet(Reports?.Homography, out homography);

        /// <summary>The poses of camera and marker; false if the service has none.</summary>
        public bool TryGetPose(out HaloPose pose) => TryGet(Reports?.Pose, out pose);

        /// <summary>The state of the service; false if it is not known yet.</summary>
        public bool TryGetHealth(out HaloHealth health) => TryGet(Reports?.Health, out health);

        SurfaceReports Reports
        {
            get
            {
                if (_client == null) return null;
                var session = _client.Session;
                if (!session.IsFollowing) return session.Known.Newest();
                return session.Known.Find(session.Current.Node, session.Current.Surface);
            }
        }

        static bool TryGet<T>(T? known, out T value) where T : struct
        {
            value = known.GetValueOrDefault();
            return known.HasValue;
        }

        void OnEnable()
        {
            Open();
        }

        void OnDisable()
        {
            Close();
        }

        void Update()
        {
            if (_client != null) _client.Poll();
        }

        void Reopen()
        {
            Close();
            if (isActiveAndEnabled) Open();
        }

        void Open()
        {
            _problem = "";
            var listener = new Listener(this);
            try
            {
                _client = recording != null
                    ? Client.OpenRecording(recording.text, recording.name, loop, listener)
                    : Client.Open(source, listener);
            }
            catch (InputException error)
            {
                _problem = error.Message;
                Debug.LogError("Halo Touch: " + error.Message, this);
            }
        }

        void Close()
        {
            if (_client == null) return;
            var client = _client;
            _client = null;
            client.Dispose(); // It ends the open touches.
        }

        sealed class Listener : ISessionListener
        {
            readonly HaloReceiver _receiver;

            public Listener(HaloReceiver receiver)
            {
                _receiver = receiver;
            }

            public void OnEvent(SessionEvent found)
            {
                if (found.Kind == EventKind.Frame) _receiver.OnFrame(found.Frame);
                else if (found.Kind == EventKind.Lost) _receiver._onLost.Call(_receiver, found.Node, _receiver);
                else if (found.Kind == EventKind.Collision) _receiver.OnCollision(found);
            }
        }

        void OnFrame(HaloFrame frame)
        {
            _frame.CopyFrom(frame);
            _onFrame.Call(this, _frame, this);
            foreach (var contact in _frame.Contacts)
                (contact.IsUp ? _onUp : _onDown).Call(_frame, contact, this);
            if (_onMoved.IsEmpty) return;
            foreach (var pointer in _frame.Pointers)
                if (_frame.IsMoving(pointer)) _onMoved.Call(_frame, pointer, this);
        }

        void OnCollision(SessionEvent found)
        {
            Debug.LogWarning(
                "Halo Touch: two running services are called '" + found.Node +
                "': give one of them another name with `halo serve --node`", this);
        }
    }
}
