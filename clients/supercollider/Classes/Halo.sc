// Fingers above a table: touch, hover height and pressure from a halo service.
//
//   h = Halo.new;                                  // listens on UDP port 4256
//   h.onDown = { |touch| touch.postln };
//   h.onFrame = { |pointers| pointers.do { |p| p[\pressure].postln } };
//   h.free;

Halo {
	classvar <>defaultPort = 4256;
	var <port, <fingers, <>onDown, <>onUp, <>onFrame, <>onScene;
	var func, clock, task;

	// node, surface: what to follow; nil: the first service that sends a frame.
	*new { |port, node, surface|
		^super.new.init(port ? defaultPort, HaloFingers(node, surface))
	}

	init { |aPort, someFingers|
		port = aPort;
		fingers = someFingers;
		if(thisProcess.openUDPPort(port).not) {
			Error("halo: port % is in use; close the other program, or choose another port"
				.format(port)).throw;
		};
		func = { |message, time, sender, receivedOn|
			if(receivedOn == port) { this.receive(message, Main.elapsedTime) };
		};
		thisProcess.addOSCRecvFunc(func);
		task = Routine {
			loop {
				0.25.wait;
				this.report(fingers.expire(Main.elapsedTime));
			}
		}.play(SystemClock);
		CmdPeriod.add(this);
	}

	// The pointers of the last frame, by id: Events with the names of the protocol, such as \u, \v,
	// \x_mm, \y_mm, \hover_mm, \pressure, \force_g, and \touch (1 or 0).
	pointers { ^fingers.pointers }

	// Stop listening. The touches that go on end.
	free {
		if(func.notNil) {
			thisProcess.removeOSCRecvFunc(func);
			task.stop;
			CmdPeriod.remove(this);
			func = nil;
			this.report(fingers.touches.endAllBut([]));
		}
	}

	// Cmd-Period stops all sound and all routines: go on watching for a lost service.
	doOnCmdPeriod { if(func.notNil) { task.reset.play(SystemClock) } }

	receive { |message, now|
		this.report(fingers.receive(message, now));
		if(fingers.isWhole) { onFrame.value(fingers.pointers) };
		if(fingers.sceneChanged) { onScene.value(fingers.scene) };
	}

	report { |touches|
		touches.do { |touch|
			if(touch[\kind] == \down) { onDown.value(touch) } { onUp.value(touch) }
		}
	}
}

// Messages in, touches out. Times are arguments, in seconds.
HaloFingers {
	classvar modulus = 16777216, stale = 1.0, lost = 3.0, names;
	classvar join = 200; // Events so many ms before our first frame are late copies of earlier ones.
	var <pointers, <touches, <scene, <isWhole = false, <sceneChanged = false, <bad = 0;
	var wantedNode, wantedSurface, node, surface, session, retired;
	var frame, count, arrived, accepting, joining, joined, age, received, kinds;

	*initClass {
		names = #[\id, \slot, \hand, \finger, \touch, \u, \v, \x_mm, \y_mm, \hover_mm, \pressure,
			\vx_mm_s, \vy_mm_s, \confidence, \contacts, \force_g];
	}

	*new { |node, surface| ^super.new.init(node, surface) }

	init { |aNode, aSurface|
		wantedNode = aNode !? { aNode.asSymbol };
		wantedSurface = aSurface !? { aSurface.asSymbol };
		kinds = IdentityDictionary.new;
		retired = List.new;
		this.restart;
	}

	restart {
		frame = scene = joined = nil;
		count = received = age = 0;
		accepting = false;
		joining = true;
		pointers = IdentityDictionary.new;
		arrived = IdentityDictionary.new;
		touches = HaloTouches.new;
	}

	// Process one message, as sclang passes it on; return the touches that began or ended.
	receive { |message, now|
		var place = this.placeOf(message[0]);
		isWhole = sceneChanged = false;
		if(place.isNil) { ^[] };
		if(this.isValid(message, place[1]).not) { bad = bad + 1; ^[] };
		if(place[1] == \frame) { ^this.header(place[0], message, now) };
		if(place[0] != surface) { ^[] };
		if(place[1] == \scene) { this.readScene(message) };
		if(accepting.not) { ^[] };
		^switch(place[1],
			\pointer, { this.pointer(message); [] },
			\alive, { this.alive(message.drop(1)) },
			\down, {
				if(message[6] > (age + join)) { [] } {
					touches.down(this.touch(\down, message, message[5], message[7]))
				}
			},
			\up, {
				if(message[5] > (age + join)) { [] } {
					touches.up(this.touch(\up, message, -1.0, message[6]), joining)
				}
			},
			{ [] }
		)
	}

	// The touches that end because the service fell silent.
	expire { |now|
		var ended;
		if(node.isNil or: { now - received < lost }) { ^[] };
		ended = touches.endAllBut([]);
		node = surface = session = nil;
		this.restart;
		^ended
	}

	// [surface, kind] of an address, or nil. Only the first 64 addresses are cached: any program can send more.
	placeOf { |address|
		var known = kinds[address], parts;
		if(known.notNil) { ^known };
		parts = address.asString.split($/);
		if(parts.size != 5 or: { parts[1] != "halo" } or: { parts[2] != "1" }) { ^nil };
		known = [parts[3].asSymbol, parts[4].asSymbol];
		if(kinds.size < 64) { kinds[address] = known };
		^known
	}

	// Any program can send to this port.
	isValid { |message, kind|
		var numbers;
		switch(kind,
			\frame, {
				if(message.size < 7 or: { message[1].isKindOf(Symbol).not }) { ^false };
				if(message[2].isKindOf(Symbol).not) { ^false };
				if("^[g-z][a-z0-9_-]*$".matchRegexp(message[2].asString).not) { ^false };
				numbers = message[[3, 4, 5, 6]];
			},
			\pointer, { if(message.size < 17) { ^false }; numbers = message.drop(1) },
			\down, { if(message.size < 8) { ^false }; numbers = message.drop(1) },
			\up, { if(message.size < 7) { ^false }; numbers = message.drop(1) },
			\alive, { numbers = message.drop(1) },
			\scene, { if(message.size < 8) { ^false }; numbers = message[[4, 5, 7]] },
			{ ^true }
		);
		^numbers.every { |each|
			each.isKindOf(Integer) or: { each.isKindOf(Float) and: { each.isNaN.not and: { each.abs < inf } } }
		}
	}

	header { |aSurface, message, now|
		var ended = this.expire(now), ahead;
		accepting = false;
		if(node.isNil and: { [nil, message[1]].includes(wantedNode) } and: { [nil, aSurface].includes(wantedSurface) }) {
			node = message[1];
			surface = aSurface;
			session = message[2];
		};
		if(node != message[1] or: { surface != aSurface }) { ^ended };
		if(session != message[2]) {
			if(retired.includes(message[2])) { ^ended };
			ended = ended ++ touches.endAllBut([]);
			retired.add(session);
			if(retired.size > 64) { retired.removeAt(0) };
			this.restart;
			session = message[2];
		};
		ahead = if(frame.isNil) { 1 } { (message[3] - frame) % modulus };
		if((ahead < (modulus div: 2)) or: { now - received > stale }) {
			if(ahead != 0) { arrived = IdentityDictionary.new }; // Else a part of the same frame.
			accepting = true;
			received = now;
			frame = message[3];
			count = message[6];
			joined = joined ?? { message[[4, 5]] };
			age = ((message[4] - joined[0]) * 1000.0) + ((message[5] - joined[1]) / 1000.0);
		};
		^ended
	}

	pointer { |message|
		var pointer = ();
		names.do { |name, i| pointer[name] = message[i + 1] };
		arrived[message[1]] = pointer;
	}

	touch { |kind, message, strike, contacts|
		^(kind: kind, id: message[1], slot: message[2], u: message[3], v: message[4],
			strike_mm_s: strike, contacts: contacts)
	}

	// Pointers of a missing part stay where they were, if they are alive.
	alive { |ids|
		var found, next = IdentityDictionary.new;
		ids.do { |id| (arrived[id] ? pointers[id]) !? { |pointer| next[id] = pointer } };
		pointers = next;
		if(arrived.size < count) { ^[] }; // The next frame repeats the events of a missing part.
		found = touches.infer(ids.collect { |id| pointers[id] }.reject(_.isNil), joining);
		joining = false;
		isWhole = true;
		^found
	}

	readScene { |message|
		var next;
		if(message[1] != node or: { message[2] != session }) { ^this };
		next = (width_mm: message[4], height_mm: message[5], revision: message[7]);
		sceneChanged = scene.isNil or: { scene[\revision] != next[\revision] };
		scene = next;
	}
}

// Each touch once: repeated events count once, lost ones are inferred from the pointers.
HaloTouches {
	classvar remembered = 256;
	var fingers; // id -> its place, and the last touches that began and ended

	*new { ^super.new.init }
	init { fingers = IdentityDictionary.new }

	down { |touch|
		var finger = this.finger(touch), ended;
		if(touch[\contacts] <= finger[\begun]) { ^[] };
		ended = this.end(touch[\id]);
		finger[\begun] = touch[\contacts];
		finger[\ended] = touch[\contacts] - 1;
		^ended ++ [touch]
	}

	up { |touch, joining|
		var finger = this.finger(touch), begun;
		if(touch[\contacts] <= finger[\ended]) { ^[] };
		if(joining and: { touch[\contacts] > finger[\begun] }) { // It began before we joined.
			finger[\begun] = touch[\contacts];
			finger[\ended] = touch[\contacts];
			^[]
		};
		begun = this.down(touch.copy.put(\kind, \down));
		finger[\ended] = touch[\contacts];
		^begun ++ [touch]
	}

	// The touches of a whole frame that no event has reported.
	infer { |pointers, joining|
		var found = [];
		pointers.do { |pointer|
			var touch = (kind: \down, strike_mm_s: -1.0), finger;
			[\id, \slot, \u, \v, \contacts].do { |name| touch[name] = pointer[name] };
			finger = this.finger(touch);
			if(joining and: { touch[\contacts] > finger[\begun] }) {
				finger[\begun] = touch[\contacts];
				finger[\ended] = touch[\contacts] - pointer[\touch];
			};
			found = found ++ this.down(touch);
			if(pointer[\touch] == 0) { found = found ++ this.end(touch[\id]) };
		};
		^found ++ this.endAllBut(pointers.collect { |pointer| pointer[\id] })
	}

	endAllBut { |ids|
		var gone = fingers.keys.reject { |id| ids.includes(id) }.asArray.sort;
		var ended = gone.collect { |id| this.end(id) }.flatten(1);
		(gone.size - remembered).do { |i| fingers.removeAt(gone[i]) };
		^ended
	}

	finger { |touch|
		var finger = fingers[touch[\id]] ?? { (begun: 0, ended: 0) };
		fingers[touch[\id]] = finger;
		[\slot, \u, \v].do { |name| finger[name] = touch[name] };
		^finger
	}

	end { |id|
		var finger = fingers[id];
		if(finger[\ended] >= finger[\begun]) { ^[] };
		finger[\ended] = finger[\begun];
		^[(kind: \up, id: id, slot: finger[\slot], u: finger[\u], v: finger[\v],
			strike_mm_s: -1.0, contacts: finger[\begun])]
	}
}
