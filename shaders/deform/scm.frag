#version 450 core
// The contact pass of scm: the soil's answer to the object. One invocation for each row (soil.glsl). Images change in place: of
// its neighbours a post reads only the base and the deposited thickness, which this pass does not write.
// Defines: FORCES: sums forces and moments; PATCH: b follows from the counted posts; LOAD: the equilibrium height was found.

#include "lib/soil.glsl"
#include "lib/tally.glsl"
#include "lib/scm_post.glsl"
#if defined(PATCH) || defined(LOAD)
#include "lib/found.glsl"
#endif

layout(binding = 3, r32i) uniform restrict iimage2DArray offsets;
layout(binding = 4, r32i) uniform restrict iimage2DArray sinkages;
layout(binding = 5, r16ui) uniform restrict uimage2DArray shears;
layout(binding = 6, r8ui) uniform writeonly restrict uimage2DArray contacts;
layout(binding = 7, r32i) uniform writeonly restrict iimage2DArray carries;

#ifdef FORCES
// 16 words for each contact with a tag: force and moment, 64 bits for each component; then four counts:
// - area that bears, faces[0].w a post
// - the deepest sinkage, fixed-point units
// - the equilibrium height above the prescribed one, fixed-point units
// - posts whose share was too large to count
layout(std430, binding = 1) restrict buffer records {
	int record[];
};

const int AREA = 12, DEEPEST = 13, RAISED = 14, SATURATED = 15;
const int SUNK = int(0x80000000u); // a bit beside the number of saturated posts: the soil does not carry the load
const float MOST = 2147483000.0;

void record_add(int at, total t)
{
	uvec2 words = total_words(t);
	uint before = uint(atomicAdd(record[at], int(words.x)));
	atomicAdd(record[at + 1], int(words.y + uint(before + words.x < before)));
}
#endif

#ifdef LOAD
layout(std430, binding = 3) restrict buffer standings {
	int standing[]; // for each loaded body: equilibrium height above the prescribed one, fixed-point units
};
#endif

void main()
{
	int y = row_of_pass();
	if (y >= written.w)
		return;
	int raised = 0;
	float by_width = scale.w;
#ifdef LOAD
	attempt found = found_next(zero.w >> 16, int(load.y));
	raised = found.at;
	if (y == written.y && load.z > 0.0)
		standing[int(load.z) - 1] = raised;
#endif
#ifdef PATCH
	by_width = found_by_width(tries[zero.w >> 16].posts, place.w);
#endif
	for (int x = written.x; x < written.z; x++)
		if (imageLoad(bases, ivec3(x, y, zero.z)).r == BASE_NODATA)
			imageStore(contacts, ivec3(x, y, zero.z), uvec4(HOLE));
	int first = shadow.z, last = shadow.x;
	for (int x = shadow.x; x < shadow.z && y >= shadow.y && y < shadow.w; x++) {
		ground g = ground_at(x, y);
		object o = object_at(x, y, raised);
#ifdef FORCES
		bool touches = may_touch(g, o) || may_bear(x, y, g, o);
#else
		bool touches = may_touch(g, o);
#endif
		first = touches ? min(first, x) : first;
		last = touches ? x + 1 : last;
	}
	total lost = total(0, 0u);
	uint over = 0u;
#ifdef FORCES
	total force[3] = total[3](lost, lost, lost), moment[3] = total[3](lost, lost, lost);
	int deepest = 0, area = 0, saturated = 0;
#endif
	ground west = ground_at(first - 1, y), g = ground_at(first, y), east;
	for (int x = first; x < last; x++, west = g, g = east) {
		ivec3 post = ivec3(x, y, zero.z);
		east = ground_at(x + 1, y);
		object o = object_at(x, y, raised);
		soil s = soil_at(x, y);
		post_state before = {imageLoad(offsets, post).r, imageLoad(heaps, post).r, imageLoad(sinkages, post).r, imageLoad(shears, post).r};
		vec3 n = normal_of(west, g, east, ground_at(x, y - 1), ground_at(x, y + 1));
		bearing b = bearing_of(s, by_width, n, g, o, cell_at(x, y, o), before);
		over += uint(b.refused);
		total_add(lost, before.offset - b.after.offset - b.carried);
		if (b.touched) {
			imageStore(offsets, post, ivec4(b.after.offset));
			imageStore(sinkages, post, ivec4(b.after.sinkage));
			imageStore(shears, post, uvec4(b.after.shear));
			imageStore(contacts, post, uvec4(LOWERED | (b.held ? HELD : 0u)));
			imageStore(carries, post, ivec4(b.carried));
		}
#ifdef FORCES
		vec3 f = b.stress * scale.z, m = b.moment * scale.z * place.z;
		bool bears = g.base != BASE_NODATA && b.area > 0.0;
		f = bears ? f : vec3(0.0);
		m = bears ? m : vec3(0.0);
		vec3 large = max(abs(f), abs(m));
		float most = bears ? MOST * min(b.area, 1.0) : 0.0;
		saturated += int(max(large.x, max(large.y, large.z)) > most);
		for (int i = 0; i < 3; i++) {
			total_add(force[i], int(round(clamp(f[i], -most, most))));
			total_add(moment[i], int(round(clamp(m[i], -most, most))));
		}
		area += bears ? int(round(b.area * faces[0].w)) : 0;
		deepest = max(deepest, b.held ? b.sunk : 0);
#endif
	}
#if defined(FORCES) && defined(LOAD)
	if (y == written.y) {
		record[(zero.w & 0xffff) * 16 + RAISED] = raised;
		if (found.top > -2000000000 && raised <= found.top - int(load.y) + 1)
			atomicOr(record[(zero.w & 0xffff) * 16 + SATURATED], SUNK);
	}
#endif
	if (last <= first)
		return;
	tally_sum(COMPACTED, total_words(lost));
	if (over > 0u)
		tally_add(REFUSED, over);
#ifdef FORCES
	int to = (zero.w & 0xffff) * 16;
	for (int i = 0; i < 3; i++) {
		record_add(to + 2 * i, force[i]);
		record_add(to + 6 + 2 * i, moment[i]);
	}
	atomicAdd(record[to + AREA], area);
	atomicMax(record[to + DEEPEST], deepest);
	atomicAdd(record[to + SATURATED], saturated);
#endif
}
