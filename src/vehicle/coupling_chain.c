/* What moves a geom that touches the soil: its freedoms, and how fast they move it. */
#include "vehicle/coupling.h"

/* Lists a freedom and those above it. Returns their number. list NULL: only counts. */
static int list_chain(const mjModel *model, int dof, int *list)
{
	int count = 0;
	for (int i = dof; i >= 0; i = model->dof_parentid[i])
		count++;
	for (int i = dof, at = count; i >= 0 && list != NULL; i = model->dof_parentid[i])
		list[--at] = i;
	return count;
}

static int last_dof(const mjModel *model, int body)
{
	while (body > 0 && model->body_dofnum[body] == 0)
		body = model->body_parentid[body];
	return body > 0 ? model->body_dofadr[body] + model->body_dofnum[body] - 1 : -1;
}

static bool is_above(const mjModel *model, int dof, int below)
{
	while (below > dof)
		below = model->dof_parentid[below];
	return below == dof;
}

/* Finds the place of a pair of freedoms in M, row >= column; -1: M has none. */
static int place_in_mass(const mjModel *model, int row, int column)
{
	const int from = model->M_rowadr[row], count = model->M_rownnz[row];
	for (int i = 0; i < count; i++)
		if (model->M_colind[from + i] == column)
			return from + i;
	return -1;
}

static enum status find_places(const struct vehicle *vehicle, struct soil_geom *geom)
{
	const mjModel *model = vehicle->model;
	const int count = geom->chain_count;
	TRY(mem_make(&geom->places, (size_t)(count * (count + 1) / 2) + 1, sizeof *geom->places, "a vehicle"));
	for (int a = 0, at = 0; a < count; a++)
		for (int b = 0; b <= a; b++, at++) {
			geom->places[at] = place_in_mass(model, geom->chain[a], geom->chain[b]);
			if (geom->places[at] >= 0 || (geom->apart && a == count - 1))
				continue;
			geom->lone = true;
			if (geom->apart || count > LONE_MOST)
				return fail_with(STATUS_FAILED, "%s: MuJoCo's inertia has no room for how the soil couples its joints; add a body below its own", geom->name);
		}
	return STATUS_OK;
}

static enum status find_chain(const struct vehicle *vehicle, struct soil_geom *geom)
{
	const mjModel *model = vehicle->model;
	const int last = last_dof(model, model->geom_bodyid[geom->geom]), hinge = geom->shape.belt ? geom->dof : -1;
	int lowest = last;
	geom->hinge_at = -1;
	geom->apart = hinge >= 0 && last >= 0 && !is_above(model, hinge, last) && !is_above(model, last, hinge);
	if (hinge >= 0 && !geom->apart && hinge > last)
		lowest = hinge;
	const int count = list_chain(model, lowest, NULL);
	TRY(mem_make(&geom->chain, (size_t)count + 2, sizeof *geom->chain, "a vehicle"));
	geom->chain_count = list_chain(model, lowest, geom->chain);
	if (geom->apart)
		geom->chain[geom->chain_count++] = hinge;
	for (int i = 0; i < geom->chain_count && hinge >= 0; i++)
		if (geom->chain[i] == hinge)
			geom->hinge_at = i;
	return find_places(vehicle, geom);
}

enum status vehicle_make_room(struct vehicle *vehicle)
{
	size_t numbers = 0;
	for (size_t i = 0; i < vehicle->geom_count; i++) {
		TRY(find_chain(vehicle, &vehicle->geoms[i]));
		numbers += 6 * (size_t)vehicle->geoms[i].chain_count * (vehicle->geoms[i].carries ? 2 : 1);
	}
	vehicle->contacts = mem_calloc(vehicle->geom_count + vehicle->carrying_count + 1, sizeof *vehicle->contacts);
	vehicle->columns = mem_calloc(numbers + 1, sizeof *vehicle->columns);
	return vehicle->contacts != NULL && vehicle->columns != NULL ? STATUS_OK : fail_memory("a vehicle");
}

void vehicle_coupling_fill_jacobians(struct vehicle *vehicle, double *wide)
{
	const mjModel *model = vehicle->model;
	double *next = vehicle->columns;
	for (size_t i = 0; i < vehicle->contact_count; i++) {
		struct contact *contact = &vehicle->contacts[i];
		const struct soil_geom *geom = contact->geom;
		const int count = geom->chain_count;
		contact->columns = (double(*)[6])next;
		next += 6 * count;
		mj_jacGeom(model, vehicle->data, wide, wide + 3 * model->nv, geom->geom);
		for (int c = 0; c < count; c++)
			for (int k = 0; k < 6; k++)
				contact->columns[c][k] = wide[k * model->nv + geom->chain[c]];
		for (int k = 0; k < 3 && geom->shape.belt; k++)
			contact->columns[geom->hinge_at][k] -= geom->sprocket * contact->forward[k];
	}
}

void vehicle_coupling_add_force(const struct contact *contact, const double force[6], double *forces)
{
	for (int c = 0; c < contact->geom->chain_count; c++)
		for (int k = 0; k < 6; k++)
			forces[contact->geom->chain[c]] += contact->columns[c][k] * force[k];
}
