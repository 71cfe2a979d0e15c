// What a contact of scm does at one post: its new state, and the stress of the soil on the object there. The contact pass and the search
// for the equilibrium height share it, so that both find the same force.

const int CARRIED_MOST = 1 << 23;

// What a post remembers, in the units of its planes.
struct post_state {
	int offset, heap, sinkage;
	uint shear;
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

// n: normal of the ground; at: the post under the object, from its centre, m.
bearing bearing_of(soil s, float by_width, vec3 n, ground g, object o, vec3 at, post_state before)
{
	bearing b;
	b.after = before;
	answer a = answer_of(s, by_width, n.z, g, o, before.sinkage);
	b.touched = a.touched && may_touch(g, o);
	b.held = a.held && b.touched;
	float was = float(before.sinkage) * UNIT_METRES;
	float was_plastic = plastic_part(s, was, yield_stress(s, by_width, was));
	int released = int(round(min(a.plastic / n.z * 1048576.0, 1.9e9)));
	int had = int(round(min(was_plastic / n.z * 1048576.0, 1.9e9)));
	b.sunk = b.held ? g.height - o.rests : released;
	b.refused = b.touched && (g.far || b.sunk > OFFSET_LIMIT || abs(before.heap - b.sunk) > OFFSET_LIMIT);
	b.touched = b.touched && !b.refused;
	b.held = b.held && !b.refused;
	b.carried = b.touched ? int(min(spin.w * float(max(released - had, 0)), float(CARRIED_MOST))) : 0;

	vec3 surface = way_of_surface(at);
	vec3 along = surface - dot(surface, n) * n;
	float slid = length(along);
	if (b.touched) {
		b.after.offset = before.heap - b.sunk;
		b.after.sinkage = a.most;
		b.after.shear = b.held ? min(before.shear + uint(round(min(slid, 1.0) * 65536.0)), 65535u) : before.shear;
	}
	b.normal = a.stress + damped(s, at, n);
	float mobilised = 1.0 - exp2(-min(float(b.after.shear) * s.b.z * (1.442695 / 65536.0), 100.0));
	float tangent = (s.b.x + b.normal * s.b.y) * mobilised;
	b.stress = b.normal * n - (slid > 1e-9 ? tangent / slid : 0.0) * along;
	b.stiff = a.stiff * n.z * n.z;
	return b;
}
