// What a contact of scm does at one post: its new state, and the stress of the soil on the object there. The contact pass and the search
// for the equilibrium height share it, so that both find the same force.

const int CARRIED_MOST = 1 << 23;

// What a post remembers, in the units of its planes.
struct post_state {
	int offset, heap, sinkage;
	int dug;   // what slip has dug since the contact with the post began
	int shear; // mobilised shear: two halves of 16 bits, 2^-15, to the east and (high) to the north
};

struct bearing {
	post_state after;
	bool touched, held; // the contact changed it; the object rests on it at the end
	bool refused;       // the change is too large for its planes, and was not made
	int carried;        // what is deposited around, fixed-point units
	int sunk;           // how far the end pose is below the undisturbed surface, fixed-point units
	float normal;       // stress along the normal of the ground, Pa
	vec3 stress;        // of the soil on the object, Pa: times the post's area it is a force
	float stiff;        // how its vertical part grows with the sinkage, Pa/m
};

vec2 shear_of(int post)
{
	return vec2(bitfieldExtract(post, 0, 16), bitfieldExtract(post, 16, 16)) * exp2(-15.0);
}

int shear_post(vec2 shear)
{
	ivec2 whole = ivec2(round(clamp(shear * 32768.0, -32767.0, 32767.0)));
	return (whole.x & 0xffff) | whole.y << 16;
}

// Vectors along a surface, as they are kept: turned into the level by the shortest way. So they keep their length when the surface
// turns under a wheel.
vec2 levelled(vec3 along, vec3 n)
{
	return along.xy - n.xy * (along.z / (1.0 + n.z));
}

vec3 tilted(vec2 level, vec3 n)
{
	float down = dot(n.xy, level);
	return vec3(level - n.xy * (down / (1.0 + n.z)), -down);
}

// Mobilised shear e, after the surface above slid along it by `along`, in units of the shear modulus: de = d(along) - e |d(along)|.
// From rest that is Janosi's 1 - exp(-j / K). It is exact on a straight way, however that is cut into contacts.
vec2 sheared(vec2 before, vec2 along)
{
	float way = length(along), stays = exp2(-1.442695 * min(way, 100.0));
	return before * stays + along * ((1.0 - stays) / max(way, 1e-30));
}

#ifdef SLIP
// What slip has dug at the end of the contact: kappa K (1 - exp(-j / K)), j the slip since the contact with the post began.
int dug_after(soil s, int before)
{
	float most = min(digs.y / s.b.z * 1048576.0, 1e8), lacks = exp2(-1.442695 * min(digs.x * s.b.z, 100.0));
	return before + int(round(max(most - float(before), 0.0) * (1.0 - lacks)));
}
#endif

// n: normal of the ground; at: the post under the object, from its centre, m.
bearing bearing_of(soil s, float by_width, vec3 n, ground g, object o, vec3 at, post_state before)
{
	bearing b;
	b.after = before;
#ifdef SLIP
	// Where the soil still bears when it is dug, it is; where it does not, the object has dug itself free.
	int dug = dug_after(s, before.dug), more = dug - before.dug;
	ground lower = g;
	lower.height -= more;
	answer a = answer_of(s, by_width, n.z, lower, o, before.sinkage);
	bool held = a.held && a.touched && may_touch(lower, o);
	if (held) {
		g = lower;
	} else {
		a = answer_of(s, by_width, n.z, g, o, before.sinkage);
		dug = more = 0;
	}
	b.touched = a.touched && may_touch(g, o);
	b.held = held;
#else
	const int dug = 0, more = 0;
	answer a = answer_of(s, by_width, n.z, g, o, before.sinkage);
	b.touched = a.touched && may_touch(g, o);
	b.held = a.held && b.touched;
#endif
	float was = float(before.sinkage) * UNIT_METRES;
	float was_plastic = plastic_part(s, was, yield_stress(s, by_width, was));
	int released = int(round(min(a.plastic / n.z * 1048576.0, 1.9e9)));
	int had = int(round(min(was_plastic / n.z * 1048576.0, 1.9e9)));
	b.sunk = b.held ? g.height - o.rests : released;
	b.refused = b.touched && (g.far || b.sunk > OFFSET_LIMIT || abs(before.heap - more - b.sunk) > OFFSET_LIMIT);
	b.touched = b.touched && !b.refused;
	b.held = b.held && !b.refused;
	b.carried = b.touched ? int(min(spin.w * float(max(released - had, 0)), float(CARRIED_MOST - more))) + more : 0;

	vec3 surface = way_of_surface(at);
	vec3 along = surface - dot(surface, n) * n;
	if (b.touched) {
		b.after.heap = before.heap - more;
		b.after.offset = b.after.heap - b.sunk;
		b.after.sinkage = a.most;
	}
	b.after.dug = b.held ? dug : 0;
	b.after.shear = b.held ? shear_post(sheared(shear_of(before.shear), levelled(along, n) * s.b.z)) : 0;
	b.normal = a.stress + damped(s, at, n);
	b.stress = b.normal * n - (s.b.x + b.normal * s.b.y) * tilted(shear_of(b.after.shear), n);
	b.stiff = a.stiff * n.z * n.z;
	return b;
}
