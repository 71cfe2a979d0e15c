#version 450 core
// One try of scm's search before the contact pass: for the size of the contact patch, or for the equilibrium height. It sums over
// the posts that an object touches. One invocation for each row (soil.glsl).
// Defines: GAP: finds the height of the first contact. COUNT: counts touched posts. Neither: sums the force that the soil bears.
// PATCH: b follows from the count.

#include "lib/soil.glsl"
#include "lib/found.glsl"
#include "lib/scm_post.glsl"

layout(binding = 3, r32i) uniform readonly restrict iimage2DArray sinkages;
layout(binding = 4, r32i) uniform readonly restrict iimage2DArray shears;

const int NOWHERE = -2000000000;

#ifdef GAP
void find(int y, int first, int last)
{
	int highest = NOWHERE;
	for (int x = first; x < last; x++) {
		ground g = ground_at(x, y);
		object o = object_at(x, y, 0);
		vec3 n = normal_of(ground_at(x - 1, y), g, ground_at(x + 1, y), ground_at(x, y - 1), ground_at(x, y + 1));
		float deepest = deepest_in(n, g, o, cell_at(x, y, o)) * 1048576.0;
		highest = max(highest, g.base != BASE_NODATA && !g.far && deepest > -1e9 ? int(deepest) : NOWHERE);
	}
	if (highest > NOWHERE)
		atomicMax(tries[0].gap, uint(highest) ^ 0x80000000u);
}
#elif defined(COUNT)
void find(int y, int first, int last)
{
	attempt a = found_next(zero.w, int(load.y));
	uint posts = 0u;
	for (int x = first; x < last; x++) {
		ground g = ground_at(x, y);
		object o = object_at(x, y, a.at);
		posts += uint(g.base != BASE_NODATA && o.rests < g.height);
	}
	if (posts > 0u)
		atomicAdd(tries[zero.w].posts, posts);
}
#else
void add_to(int k, bool stiff, uvec2 words)
{
	if (stiff) {
		uint before = atomicAdd(tries[k].stiff[0], words.x);
		atomicAdd(tries[k].stiff[1], words.y + uint(before + words.x < before));
	} else {
		uint before = atomicAdd(tries[k].force[0], words.x);
		atomicAdd(tries[k].force[1], words.y + uint(before + words.x < before));
	}
}

void find(int y, int first, int last)
{
	int k = zero.w;
	attempt a = found_next(k, int(load.y));
#ifdef PATCH
	float by_width = found_by_width(tries[k].posts, place.w);
#else
	float by_width = scale.w;
#endif
	if (y == shadow.y) {
		tries[k].low = a.low;
		tries[k].high = a.high;
		tries[k].top = a.top;
		tries[k].at = a.at;
		tries[k].done = a.done;
	}
	total force = total(0, 0u), stiff = total(0, 0u);
	float unit = 67108864.0 * place.w / load.x;
	for (int x = first; x < last && a.done == 0u; x++) {
		ground g = ground_at(x, y);
		object o = object_at(x, y, a.at);
		vec3 n = normal_of(ground_at(x - 1, y), g, ground_at(x + 1, y), ground_at(x, y - 1), ground_at(x, y + 1));
		ivec3 post = ivec3(x, y, zero.z);
		post_state before = {0, 0, imageLoad(sinkages, post).r, 0, imageLoad(shears, post).r};
#ifdef SLIP
		before.dug = imageLoad(dugs, post).r;
#endif
		bearing w = bearing_of(soil_at(x, y), by_width, n, g, o, cell_at(x, y, o), before);
		bool bears = g.base != BASE_NODATA && w.area > 0.0;
		total_add(force, bears ? int(round(clamp(w.stress.z * unit, -1e9, 1e9))) : 0);
		total_add(stiff, bears ? int(round(min(w.stiff * UNIT_METRES * unit, 1e9))) : 0);
	}
	if (a.done == 0u) {
		add_to(k, false, total_words(force));
		add_to(k, true, total_words(stiff));
	}
}
#endif

void main()
{
	int y = row_of_pass() - written.y + shadow.y;
	if (y < shadow.w)
		find(y, shadow.x, shadow.z);
}
