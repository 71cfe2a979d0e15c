/*
 * Part of stress.h: a layer of soil over another one. SI. Pure.
 *
 * A square plate of width B spreads its pressure p with the depth y as p B^2 / (B + y)^2. That is the 2:1 method of foundation engineering (Bowles 1996,
 * Foundation Analysis and Design, 5-3). So soil within a depth h below the plate gives the part h / (h + B) of its settlement, and soil below that
 * gives the rest. Strains of layers add up, as in Steinbrenner 1934. Each soil counts with its secant stiffness p_i(z) / z at the plate's sinkage z, with
 * Bekker's p_i(z) and the elastic limit. So, with r = p_1 / p_2 of the layer and its base,
 *
 *     1 / p = h / (h + B) / p_1 + B / (h + B) / p_2,   or   p = p_1 (h + B) / (h + B r)
 *
 * h is what is left of the layer's thickness H. A layer that is softer than its base is squeezed by its part of the sinkage, times 1 - r. One that is
 * not goes down with the plate, as a whole.
 *
 *     H - h = z (1 - r) h / (h + B r)     for r < 1
 *
 * That is a quadratic equation for h. Over rigid ground (r = 0) h = H - z and p = p_1(z) (1 + B / (H - z)), which grows without end: no body comes
 * through. Without a layer (H = 0) p = p_2, and with an endless one p = p_1. p grows with z, whatever the soils.
 *
 * Unloaded soil springs back along the elastic curve E: the same with p_i = K_i z, K_i the stiffness of unloading. The plastic sinkage z_0 after p(z) is
 * where E(z_0) = E(z) - p(z). It is less than H over rigid ground.
 *
 * A loose layer (memory.h) of the thickness L lies on the layer as on any floor. The floor is the layer as it was left, at its plastic sinkage u. It springs
 * along E(u + z - L) - E(u), and yields by p(u + z - L). The loose layer yields alone until the body is through it, by Bekker's curve or by p(u + z),
 * whichever is less. Over soft ground all of it goes down together. Down to L all soil springs by K_1 z, and beyond by K_1 L + E(u + z - L) - E(u). This elastic curve
 * does not depend on what yields, so a cycle of loading gives no energy. H is u and what lies between the floor and the base. The heights of a post say
 * how thick its soil is, so none is lost.
 */
#ifndef FURROW_SOIL_LAYERS_H
#define FURROW_SOIL_LAYERS_H

#define LAYER_NONE 1e6f   /* m: so thick is soil that lies over no other */
#define LAYER_LEAST 1e-5f /* m: so much of a layer over rigid ground is always left. From there its stress grows evenly */
#define LAYER_FILM 1e-4f  /* m: slip leaves so much of a layer over rigid ground */
#define LAYER_RIGID 1e25f /* N/m^(n+2): of ground that bears whatever is above it */

/* How much of a layer is left at a sinkage, m; before and after its least. ratio: of the stresses of both soils. */
struct layer_left {
	float left, wide, root, kept;
};

SOIL_INLINED struct layer_left layer_left_at(float thick, float bulb, float ratio, float z)
{
	const float used = z * most(1 - ratio, 0), wide = bulb * ratio, c = wide + used - thick, root = sqrtf(c * c + 4 * thick * wide);
	const float left = either(c > 0, 2 * thick * wide / most(c + root, 1e-30f), 0.5f * (root - c));
	return (struct layer_left){most(left, LAYER_LEAST), wide, root, either(left > LAYER_LEAST, 1, 0)};
}

/* Returns by how much stresses grow beyond that: a factor. *rises: 1/m, its growth as a share of it. */
SOIL_INLINED float layer_beyond(const struct stress_soil *s, float z, float *rises)
{
	const float over = either(s->base_k > LAYER_RIGID, most(z - s->thick + LAYER_LEAST, 0), 0), factor = 1 + over * (1 / LAYER_LEAST);
	*rises = either(over > 0, 1 / (LAYER_LEAST * factor), 0);
	return factor;
}

SOIL_INLINED float layer_ratio(float own, float base)
{
	return own / most(base, 1e-20f);
}

/* Returns the stress of both soils together, Pa. own, base: of each soil alone, at this sinkage. */
SOIL_INLINED float layer_both(const struct stress_soil *s, float own, float base, float z)
{
	const float ratio = layer_ratio(own, base);
	const struct layer_left l = layer_left_at(s->thick, s->bulb, ratio, z);
	float rises;
	return least(own * (l.left + s->bulb) / (l.left + l.wide) * layer_beyond(s, z, &rises), SOIL_STRESS_MOST);
}

SOIL_INLINED float layer_stress(const struct stress_soil *s, float own, float z)
{
	return layer_both(s, own, bekker_stress(s->base_k, s->base_n, s->base_elastic, z), z);
}

/* Returns how a stress of both soils grows with the sinkage, as a share of the stress, 1/m. rises: the same of the layer's soil alone; turns: of the
 * ratio of both. */
SOIL_INLINED float layer_rise(const struct layer_left *l, float thick, float bulb, float ratio, float z, float rises, float turns)
{
	const float ratio_by = ratio * turns, used_by = either(ratio < 1, 1 - ratio - z * ratio_by, 0);
	const float left_by = l->kept * (bulb * ratio_by * (thick - l->left) - l->left * used_by) / most(l->root, 1e-9f);
	return most(rises + left_by / (l->left + bulb) - (left_by + bulb * ratio_by) / (l->left + l->wide), 0);
}

/* Returns how layer_stress grows with the sinkage, Pa/m. */
SOIL_INLINED float layer_growth(const struct stress_soil *s, float z)
{
	const float own = bekker_stress(s->k, s->n, s->elastic, z), base = bekker_stress(s->base_k, s->base_n, s->base_elastic, z), ratio = layer_ratio(own, base);
	const float rises = bekker_growth(s->n, s->elastic, own, z) / most(own, 1e-20f), base_rises = bekker_growth(s->base_n, s->base_elastic, base, z) / most(base, 1e-20f);
	const struct layer_left l = layer_left_at(s->thick, s->bulb, ratio, z);
	float beyond;
	const float factor = layer_beyond(s, z, &beyond), stress = least(own * (l.left + s->bulb) / (l.left + l.wide) * factor, SOIL_STRESS_MOST);
	return stress * (layer_rise(&l, s->thick, s->bulb, ratio, z, rises, rises - base_rises) + beyond);
}

/* --- the elastic curve --- */

/* Returns E(z), Pa. *grows: how it grows, Pa/m. */
SOIL_INLINED float layer_elastic(const struct stress_soil *s, float z, float *grows)
{
	const float ratio = s->elastic / most(s->base_elastic, 1e-20f), deep = most(z, 1e-9f);
	const struct layer_left l = layer_left_at(s->thick, s->bulb, ratio, deep);
	float beyond;
	const float factor = layer_beyond(s, deep, &beyond), stress = s->elastic * deep * (l.left + s->bulb) / (l.left + l.wide) * factor;
	*grows = stress * (layer_rise(&l, s->thick, s->bulb, ratio, deep, 1 / deep, 0) + beyond);
	return either(z > 0, stress, 0);
}

/* Returns the sinkage z_0 that stays after the soil yielded at sinkage z with a stress, m. */
SOIL_INLINED float layer_plastic(const struct stress_soil *s, float z, float yields)
{
	float grows;
	const float stress = most(layer_elastic(s, z, &grows) - yields, 0), ratio = s->elastic / most(s->base_elastic, 1e-20f);
	/* Of the elastic curve at a stress: h^2 + h (B + e - H) - H B = 0, with e = (1 - r) stress / K. */
	const float own = stress * s->by_elastic, e = own * most(1 - ratio, 0), c = s->bulb + e - s->thick, root = sqrtf(c * c + 4 * s->thick * s->bulb);
	const float left = most(either(c > 0, 2 * s->thick * s->bulb / most(c + root, 1e-30f), 0.5f * (root - c)), LAYER_LEAST);
	const float stays = own * (left + s->bulb * ratio) / (left + s->bulb);
	return least(stays, least(z, either(s->base_k > LAYER_RIGID, most(s->thick - LAYER_LEAST, 0), z)));
}

/* --- loose layer on a layer --- */

/* Returns the yield stress of the floor at its own sinkage, Pa. *grows: Pa/m. */
SOIL_INLINED float layer_floor_stress(const struct stress_soil *s, float deep, float *grows)
{
	struct stress_soil floor = *s;
	floor.k = s->whole;
	*grows = layer_growth(&floor, deep);
	return layer_stress(&floor, bekker_stress(floor.k, floor.n, floor.elastic, deep), deep);
}

/* Returns the yield stress of loose layer alone, Pa: no more than the floor bears if all soil goes down with it. own: of the soil, as if without end. */
SOIL_INLINED float layer_loose_stress(const struct stress_soil *s, float own, float z)
{
	float grows;
	return least(own, layer_floor_stress(s, most(z, 0) + s->under, &grows));
}

/* Returns how that grows with the sinkage, Pa/m. own: how that of the soil alone does. */
SOIL_INLINED float layer_loose_growth(const struct stress_soil *s, float own, float z)
{
	float grows;
	const float floor = layer_floor_stress(s, most(z, 0) + s->under, &grows);
	return either(bekker_stress(s->k, s->n, s->elastic, z) <= floor, own, grows);
}

/* Returns by how much the elastic curve of all soil at sinkage z is above that where the body reaches the floor, Pa. *grows: Pa/m. */
SOIL_INLINED float layer_above_floor(const struct stress_soil *s, float z, float *grows)
{
	float here, left;
	const float into = z - s->loose, whole = layer_elastic(s, into + s->under, &here) - layer_elastic(s, s->under, &left);
	*grows = either(into > 0, here, s->elastic);
	return either(into > 0, whole, into * s->elastic);
}

/* Returns what layer_plastic does, below loose layer. */
SOIL_INLINED float layer_floor_plastic(const struct stress_soil *s, float z, float yields)
{
	float grows;
	const float stays = layer_above_floor(s, z, &grows) - yields;
	const float loose = most(s->loose + stays * s->by_elastic, 0), floor = s->loose + layer_plastic(s, z - s->loose + s->under, yields) - s->under;
	return least(either(stays > 0, most(floor, s->loose), loose), z);
}

#define LAYER_HALVINGS 20 /* to a millionth of the sinkage */

/* Returns the plastic sinkage u of a floor, m. left: of the layer, below the floor; m. k: of the floor. z: the largest sinkage before, from where the
 * layer had the thickness left + u. So u is where that thickness gives it. */
SOIL_INLINED float layer_under(const struct stress_soil *s, float left, float k, float z)
{
	struct stress_soil floor = *s;
	float low = 0, high = z;
	const float own = bekker_stress(k, s->n, s->elastic, z), base = bekker_stress(s->base_k, s->base_n, s->base_elastic, z);
	const float below = either(s->base_k > LAYER_RIGID, most(left, 2 * LAYER_LEAST), left);
	for (int i = 0; i < LAYER_HALVINGS; i++) {
		const float middle = 0.5f * (low + high);
		floor.thick = most(below + middle, 0);
		const bool more = layer_plastic(&floor, z, layer_both(&floor, own, base, z)) > middle;
		low = either(more, middle, low);
		high = either(more, high, middle);
	}
	return low;
}

/* Returns which share of the yield stress at the largest sinkage the soil bears at sinkage z. *grows: how that grows, 1/m. */
SOIL_INLINED float layer_springs(const struct stress_soil *s, float z, float largest, float yields, float *grows)
{
	float there, here, far, near;
	const float by = 1 / most(yields, 1e-9f), own = layer_elastic(s, largest, &there) - layer_elastic(s, z, &here);
	const float loose = layer_above_floor(s, largest, &far) - layer_above_floor(s, z, &near), share = 1 - either(s->loose > 0, loose, own) * by;
	*grows = either(s->loose > 0, near, here) * by;
	return clamped(share, 0, 1);
}

/* Returns how much of a layer's own shear counts at a sinkage. 1: what is left of it is thicker than its shear modulus. */
SOIL_INLINED float layer_shears(const struct stress_soil *s, float z)
{
	const float deep = either(s->loose > 0, most(z - s->loose, 0) + s->under, z), k = either(s->loose > 0, s->whole, s->k);
	const float own = bekker_stress(k, s->n, s->elastic, deep), ratio = layer_ratio(own, bekker_stress(s->base_k, s->base_n, s->base_elastic, deep));
	const struct layer_left l = layer_left_at(s->thick, s->bulb, either(deep > 0, ratio, 0), deep);
	return least((either(deep > 0, l.left, s->thick) + most(s->loose - most(z, 0), 0)) * s->by_modulus, 1);
}

#endif
