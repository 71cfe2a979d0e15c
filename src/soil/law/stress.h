/*
 * The soil's law at one place: stress and strength of the soil, and how a surface shears it. Pressure and sinkage: Bekker. Shear: Janosi and
 * Hanamoto, as a differential equation. Elastic rebound: Krenn and Hirzinger 2009. SI. Pure.
 */
#ifndef FURROW_SOIL_STRESS_H
#define FURROW_SOIL_STRESS_H

#include "soil/law/real.h"

#ifndef SOIL_LAYERED
#define SOIL_LAYERED 0 /* 1: of a post whose soil may lie over another. Such ground has functions of its own, so that other ground pays nothing */
#endif

#define SOIL_UNIT 0x1p-20f         /* m: a fixed-point unit */
#define SOIL_LEAST 1.2e-6f         /* m: a stored sinkage and a height are each rounded by up to half a unit */
#define SOIL_STRESS_MOST 1e20f     /* Pa: keeps all numbers finite */

/* The soil of a post. k: k_c / b + k_phi, N/m^(n+2), b the width of the contact patch. modulus: of shear, m. */
struct stress_soil {
	float k, n, elastic, by_elastic, cohesion, tan_phi, modulus, by_modulus, damping;
	/* A loose layer on a floor. k of the floor; thickness of the layer along the normal, m, 0: none; the floor's plastic sinkage, m. */
	float whole, loose, under;
	/* With SOIL_LAYERED. How thick the soil below a loose layer is along the normal, m, LAYER_NONE: endless; the pressure bulb, m; the soil below it. */
	float thick, bulb, base_k, base_n, base_elastic;
};

/* Returns the stress that soil of these numbers bears at sinkage z, m, when it yields; Pa. */
SOIL_INLINED float bekker_stress(float k, float n, float elastic, float z)
{
	const float bekker = k * power_of(most(z, SOIL_UNIT), n);
	return either(z > 0, least(least(bekker, z * elastic), SOIL_STRESS_MOST), 0);
}

/* Returns how that grows with the sinkage, Pa/m. */
SOIL_INLINED float bekker_growth(float n, float elastic, float yields, float z)
{
	const float flows = yields * n / most(z, SOIL_UNIT);
	return either(yields >= 0.9999999f * elastic * z, elastic, flows);
}

#include "soil/law/layers.h"

/* Returns the stress that the ground bears at sinkage z, m, when it yields; Pa. Of a loose layer: without its floor. */
SOIL_INLINED float yield_stress(const struct stress_soil *s, float z)
{
	const float own = bekker_stress(s->k, s->n, s->elastic, z);
	return SOIL_LAYERED ? either(s->thick < LAYER_NONE, either(s->loose > 0, layer_loose_stress(s, own, z), layer_stress(s, own, z)), own) : own;
}

/* Returns how the yield stress grows with the sinkage, Pa/m. */
SOIL_INLINED float yield_growth(const struct stress_soil *s, float yields, float z)
{
	const float own = bekker_growth(s->n, s->elastic, yields, z);
	return SOIL_LAYERED ? either(s->thick < LAYER_NONE, either(s->loose > 0, layer_loose_growth(s, own, z), layer_growth(s, z)), own) : own;
}

/* Returns the plastic part of sinkage z, m: what stays after unloading. */
SOIL_INLINED float plastic_part(const struct stress_soil *s, float z, float yields)
{
	const float own = most(z - yields * s->by_elastic, 0);
	return SOIL_LAYERED ? either(s->thick < LAYER_NONE, either(s->loose > 0, layer_floor_plastic(s, z, yields), layer_plastic(s, z, yields)), own) : own;
}

/* Returns which share of the yield stress soil bears that was loaded to a larger sinkage before, m. plastic: the part of it that stays. by_elastic: 1/m,
 * how the share grows with the sinkage. */
SOIL_INLINED float springs_at(const struct stress_soil *s, float z, float largest, float yields, float plastic, float *by_elastic)
{
	const float own = 1 / most(largest - plastic, 1e-9f), share = clamped((z + SOIL_LEAST - plastic) * own, 0, 1);
	float grows;
	if (!SOIL_LAYERED) {
		*by_elastic = own;
		return share;
	}
	const float springs = layer_springs(s, z + SOIL_LEAST, largest, yields, &grows);
	*by_elastic = either(s->thick < LAYER_NONE, grows, own);
	return either(s->thick < LAYER_NONE, springs, share);
}

SOIL_INLINED float plastic_of(const struct stress_soil *s, float z)
{
	return plastic_part(s, z, yield_stress(s, z));
}

/* --- a loose layer on a floor (memory.h) --- */

/* Returns the stress that the floor below a loose layer bears at sinkage z of the layer, Pa. *grows: Pa/m. It is loaded anew from where it was left,
 * and yields beyond. */
SOIL_INLINED float floor_stress(const struct stress_soil *s, float z, float *grows)
{
	const float into = z - s->loose, deep = into + s->under, bekker = s->whole * power_of(most(deep, SOIL_UNIT), s->n), springs = into * s->elastic;
	float flows, rises;
	*grows = either(bekker < springs, bekker * s->n / most(deep, SOIL_UNIT), s->elastic);
	const float own = either((into > 0) & (s->loose > 0), least(least(bekker, springs), SOIL_STRESS_MOST), 0);
	if (!SOIL_LAYERED)
		return own;
	const float yields = layer_floor_stress(s, deep, &flows), loads = layer_above_floor(s, z, &rises);
	*grows = either(s->thick < LAYER_NONE, either(yields < loads, flows, rises), *grows);
	return either((s->thick < LAYER_NONE) & (into > 0) & (s->loose > 0), least(least(yields, loads), SOIL_STRESS_MOST), own);
}

/* The same as yield_stress, yield_growth and plastic_of, of soil that may lie loose on a floor. `floored` false: it does not. */
SOIL_INLINED float yield_stress_on(const struct stress_soil *s, float z, bool floored)
{
	float grows;
	const float yields = yield_stress(s, z);
	return floored ? most(yields, floor_stress(s, z, &grows)) : yields;
}

SOIL_INLINED float yield_growth_on(const struct stress_soil *s, float yields, float z, bool floored)
{
	float grows;
	if (!floored)
		return yield_growth(s, yields, z);
	const float below = floor_stress(s, z, &grows), loose = yield_stress(s, z), top = yield_growth(s, loose, z);
	return either(below > loose, grows, top);
}

SOIL_INLINED float plastic_on(const struct stress_soil *s, float z, bool floored)
{
	return plastic_part(s, z, yield_stress_on(s, z, floored));
}

/* A body's surface: its adhesion, Pa, and the tangent of its friction angle. own: 1 where the soil says it: own_adhesion, or its friction angle. carries: share of
 * the surface that carries soil with it, so that soil slides on soil there. */
struct stress_surface {
	float adhesion, tangent, own[2], carries;
};

/* Returns the adhesion of a surface of which none is given, Pa. Soft soil sticks with all of its cohesion, stiff soil with less. These are the lines
 * between the rows of NAVFAC DM-7.02 (1986), chapter 3, table 1, at 0, 24, 48, 96 and 192 kPa. */
SOIL_INLINED float own_adhesion(float cohesion)
{
	return least(least(cohesion, 11970 + 0.5f * cohesion), least(26334 + 0.2f * cohesion, 28728 + 0.175f * cohesion));
}

/*
 * Returns the most that shear can hold under a normal stress, Pa: of the soil, or along the surface if that is less. *grows: with the stress. Under a
 * small stress the surface touches with a part of its area. Only that part holds by cohesion or adhesion: stress / cohesion of it, at most all. So a
 * light body is not held by more than its weight and its friction.
 */
SOIL_INLINED float strength_of(const struct stress_surface *surface, const struct stress_soil *s, float stress, float *grows)
{
	const float sticks = either(surface->own[0] > 0, own_adhesion(s->cohesion), surface->adhesion), rubs = either(surface->own[1] > 0, s->tan_phi, surface->tangent);
	const float adhesion = sticks + surface->carries * (s->cohesion - sticks), tangent = rubs + surface->carries * (s->tan_phi - rubs);
	const float by = 1 / most(s->cohesion, 1e-18f), touches = least(stress * by, 1), grown = either(stress < s->cohesion, by, 0);
	const float soil = touches * s->cohesion + s->tan_phi * stress, along = touches * adhesion + tangent * stress;
	*grows = either(soil <= along, s->tan_phi + grown * s->cohesion, tangent + grown * adhesion);
	return least(soil, along);
}

/* Two unit vectors along the surface whose normal is n: where the shortest rotation that makes the surface level has the axes of the frame. A
 * mobilised shear is stored along these, so it keeps its length as the surface turns. */
SOIL_INLINED void put_across(const float n[3], float across[2][3])
{
	const float by = 1 / (1 + n[2]);
	across[0][0] = 1 - n[0] * n[0] * by;
	across[0][1] = across[1][0] = -n[0] * n[1] * by;
	across[0][2] = -n[0];
	across[1][1] = 1 - n[1] * n[1] * by;
	across[1][2] = -n[1];
}

/* Gives the mobilised shear after the surface slid a way in a direction, in units of the shear modulus. The law is de = direction d(way) - e d(way).
 * From rest it is Janosi's 1 - exp(-j / K). It is exact, however many motions the way is cut into. stays: exp(-way). */
SOIL_INLINED float sheared(float before, float direction, float stays)
{
	return direction + stays * (before - direction);
}

/* Returns the place on a line, from -1 to 1, beyond which a parabola is above 0. It goes through three numbers at -1, 0 and 1. sign: the end
 * from which it is looked for. */
SOIL_INLINED float root_from(float sign, const float depths[3])
{
	const float bends = 0.5f * (depths[0] + depths[2]) - depths[1], rises = 0.5f * (depths[2] - depths[0]), over = depths[1];
	const float squares = rises * rises - 4 * bends * over, by = root(squares) - sign * rises;
	/* A parabola whose top misses 0 by rounding alone has one root, at its top. */
	const bool touches = (bends < 0) & (squares <= 0);
	const float top = -0.5f * rises / least(bends, -1e-18f), side = sign * 2 * over / most(by, 1e-15f), at = either(touches, top, side);
	const bool never = (squares < either(touches, 4 * bends * SOIL_LEAST, 0)) | ((by <= 0) & !touches);
	return either(depths[sign < 0 ? 0 : 2] > 0, sign, either(never, -sign, clamped(at, -1, 1)));
}

#endif
