/* furrow_mujoco.h in a loop of C: what it refuses, and who owns what. */
#include "api/furrow_mujoco.h"
#include "engine.h"

/* A foot of 20 kg that a slide lets fall. Its geom is a mesh: a box of 0.4 x 0.4 x 0.1 m. */
#define FOOT "<mujoco><option timestep=\"0.002\" integrator=\"implicit\" gravity=\"0 0 -9.80665\"/><asset><mesh name=\"sole\" vertex=\"" \
	     "-.2 -.2 -.05 .2 -.2 -.05 -.2 .2 -.05 .2 .2 -.05 -.2 -.2 .05 .2 -.2 .05 -.2 .2 .05 .2 .2 .05\"/></asset>" \
	     "<worldbody><body pos=\"0 0 0.051\"><joint name=\"z\" type=\"slide\" axis=\"0 0 1\"/><geom name=\"foot\" type=\"mesh\" mesh=\"sole\" mass=\"20\"/></body></worldbody></mujoco>"

/* The arrays that a host with another version of MuJoCo names. */
#define MODEL_ARRAYS(X) \
	X(body_parentid) X(body_rootid) X(body_weldid) X(body_jntnum) X(body_jntadr) X(body_dofnum) X(body_dofadr) X(body_geomnum) X(jnt_type) \
	X(jnt_qposadr) X(jnt_dofadr) X(dof_bodyid) X(dof_jntid) X(dof_parentid) X(dof_damping) X(dof_M0) X(body_mass) X(geom_type) X(geom_contype) \
	X(geom_conaffinity) X(geom_condim) X(geom_priority) X(geom_bodyid) X(geom_dataid) X(geom_size) X(geom_aabb) X(geom_user) X(mesh_vertadr) \
	X(mesh_vertnum) X(mesh_faceadr) X(mesh_facenum) X(mesh_vert) X(mesh_face) X(name_bodyadr) X(name_geomadr) X(name_jntadr) X(name_textadr) \
	X(name_numericadr) X(names) X(text_adr) X(text_data) X(numeric_adr) X(numeric_data) X(actuator_trntype) X(actuator_trnid) X(actuator_gear) \
	X(actuator_outadr) X(actuator_biastype) X(actuator_biasprm) X(M_rownnz) X(M_rowadr) X(M_colind)
#define DATA_ARRAYS(X) \
	X(qpos) X(qvel) X(xpos) X(xmat) X(xanchor) X(xaxis) X(geom_xpos) X(geom_xmat) X(subtree_com) X(cdof) X(cvel) X(M) X(qLD) X(qLDiagInv)
#define SIZES(X) X(nq) X(nv) X(nbody) X(njnt) X(ngeom) X(nC) X(nactuator) X(ntext) X(nnumeric) X(nuser_geom) X(opt.integrator)

struct loop {
	struct furrow_world *world;
	mjModel *model;
	mjData *data;
	struct furrow_mujoco *soil;
};

/* Opens a soil as `open` says, with arrays in place of the structs. They are enough: whatever else of MuJoCo is read is NULL there. */
static furrow_status open_named(struct loop *loop)
{
	static int64_t sizes[32];
	struct furrow_array arrays[128];
	size_t count = 0, sized = 0;
	mjModel *model = loop->model;
	mjData *data = loop->data;
#define MODEL_ARRAY(member) arrays[count++] = (struct furrow_array){"model." #member, model->member};
#define DATA_ARRAY(member) arrays[count++] = (struct furrow_array){"data." #member, data->member};
#define SIZE(member) sizes[sized] = (int64_t)model->member, arrays[count++] = (struct furrow_array){"model." #member, &sizes[sized++]};
	MODEL_ARRAYS(MODEL_ARRAY)
	DATA_ARRAYS(DATA_ARRAY)
	SIZES(SIZE)
	arrays[count++] = (struct furrow_array){"model.opt.gravity", model->opt.gravity};
	for (size_t i = 0; i < count; i++) /* an empty one has no place */
		arrays[i].at = arrays[i].at != NULL ? arrays[i].at : sizes;
	const struct furrow_mujoco_open open = {.size = sizeof open, .world = loop->world, .arrays = arrays, .array_count = count, .origin = {10, 10.5, 0}};
	return furrow_mujoco_open(&open, &loop->soil);
}

static furrow_status open_soil(struct loop *loop)
{
	const struct furrow_mujoco_open open = {.size = sizeof open, .world = loop->world, .model = loop->model, .data = loop->data, .origin = {10, 10.5, 0}};
	engine.mj_resetData(loop->model, loop->data);
	engine.mj_forward(loop->model, loop->data);
	return furrow_mujoco_open(&open, &loop->soil);
}

static struct loop begin(const char *overlay)
{
	struct loop loop = {.world = NULL};
	engine_store();
	const struct furrow_open open = {.size = sizeof open, .scene = ENGINE_SCENE, .store = support_path("ground.furrow"), .overlay = support_path(overlay)};
	assert_int_equal(furrow_world_open(&open, &loop.world), FURROW_OK);
	loop.model = engine_model(FOOT);
	assert_non_null(loop.model);
	loop.data = engine.mj_makeData(loop.model);
	assert_int_equal(open_soil(&loop), FURROW_OK);
	return loop;
}

/* A slide alone: nothing is near a limit once it stands. */
static void go(struct loop *loop, int steps)
{
	for (int i = 0; i < steps; i++) {
		double forces[1];
		bool again;
		engine.mj_step1(loop->model, loop->data);
		assert_int_equal(furrow_mujoco_begin(loop->soil, loop->data, 0.002, false, forces), FURROW_OK);
		engine.mj_factorM(loop->model, loop->data);
		loop->data->qfrc_applied[0] = forces[0];
		engine.mj_step2(loop->model, loop->data);
		assert_int_equal(furrow_mujoco_limit(loop->soil, loop->data->qvel, &again, forces), FURROW_OK);
		assert_int_equal(furrow_mujoco_end(loop->soil, loop->data->qvel), FURROW_OK);
		engine.mj_forward(loop->model, loop->data);
		assert_int_equal(furrow_mujoco_touch(loop->soil, loop->data), FURROW_OK);
	}
}

static void end(struct loop *loop)
{
	engine.mj_deleteData(loop->data);
	engine.mj_deleteModel(loop->model);
}

static void named_arrays_are_enough(void **state)
{
	(void)state;
	struct loop loop = begin("structs.furrow");
	go(&loop, 200);
	const double structs = loop.data->qpos[0];
	furrow_mujoco_close(loop.soil);
	assert_int_equal(furrow_world_close(loop.world), FURROW_OK);
	const struct furrow_open open = {.size = sizeof open, .scene = ENGINE_SCENE, .store = support_path("ground.furrow"), .overlay = support_path("named.furrow")};
	assert_int_equal(furrow_world_open(&open, &loop.world), FURROW_OK);
	engine.mj_resetData(loop.model, loop.data);
	engine.mj_forward(loop.model, loop.data);
	assert_int_equal(open_named(&loop), FURROW_OK);
	go(&loop, 200);
	assert_true(structs < 0 && loop.data->qpos[0] == structs);
	furrow_mujoco_close(loop.soil);
	assert_int_equal(furrow_world_close(loop.world), FURROW_OK);
	end(&loop);
}

static void usage(furrow_status status, const char *words)
{
	assert_int_equal(status, FURROW_USAGE);
	assert_non_null(strstr(furrow_last_error(), words));
}

static void a_foot_stands_in_a_loop_of_c(void **state)
{
	struct furrow_contact contact;
	(void)state;
	struct loop loop = begin("stands.furrow");
	go(&loop, 1000);
	assert_int_equal(furrow_mujoco_geom(loop.soil, 0, NULL, NULL, &contact, sizeof contact), FURROW_OK);
	print_message("%.3f N, sunk by %.2f mm\n", contact.force[2], 1e3 * contact.sinkage);
	assert_true(fabs(contact.force[2] - 20 * 9.80665) < 0.01 * 20 * 9.80665 && contact.sinkage > 0.001);
	furrow_mujoco_close(loop.soil);
	assert_int_equal(furrow_world_close(loop.world), FURROW_OK);
	end(&loop);
}

static void what_is_no_step_is_refused(void **state)
{
	double forces[1] = {0};
	bool again;
	(void)state;
	struct loop loop = begin("refused.furrow");
	const double qvel[1] = {0};
	usage(furrow_mujoco_begin(loop.soil, NULL, 0.002, false, forces), "data is NULL");
	usage(furrow_mujoco_begin(loop.soil, loop.data, 0.002, true, forces), "call furrow_mujoco_begin first");
	usage(furrow_mujoco_begin(loop.soil, loop.data, 0.002, false, NULL), "forces");
	usage(furrow_mujoco_begin(NULL, loop.data, 0.002, false, forces), "world");
	assert_int_equal(furrow_mujoco_begin(loop.soil, loop.data, 2, false, forces), FURROW_INPUT);
	usage(furrow_mujoco_limit(loop.soil, qvel, &again, forces), "call furrow_mujoco_begin first");
	usage(furrow_mujoco_forces(loop.soil, qvel, forces), "call furrow_mujoco_begin first");
	usage(furrow_mujoco_end(loop.soil, qvel), "call furrow_mujoco_begin first");
	usage(furrow_mujoco_touch(loop.soil, NULL), "data is NULL");
	go(&loop, 3);
	usage(furrow_mujoco_end(loop.soil, qvel), "call furrow_mujoco_begin first");
	usage(furrow_mujoco_geom(loop.soil, 1, NULL, NULL, NULL, 0), "no soil geom 1");
	struct furrow_mujoco *other;
	struct furrow_mujoco_open open = {.size = sizeof open, .world = loop.world, .name = "other", .model = loop.model};
	usage(furrow_mujoco_open(&open, &other), "give both");
	assert_null(other);
	open.model = NULL;
	assert_int_equal(furrow_mujoco_open(&open, &other), FURROW_INPUT);
	assert_non_null(strstr(furrow_last_error(), "of MuJoCo is missing"));
	open.size = 1;
	usage(furrow_mujoco_open(&open, &other), "size");
	usage(furrow_mujoco_open(&open, NULL), "out");
	furrow_mujoco_close(loop.soil);
	assert_int_equal(furrow_world_close(loop.world), FURROW_OK);
	end(&loop);
}

static void a_reset_goes_to_its_own_checkpoint_alone(void **state)
{
	(void)state;
	struct loop loop = begin("marks.furrow");
	go(&loop, 100);
	const double sunk = loop.data->qpos[0];
	assert_int_equal(furrow_mujoco_reset(loop.soil), FURROW_OK);
	engine.mj_resetData(loop.model, loop.data);
	go(&loop, 100);
	assert_true(loop.data->qpos[0] == sunk);
	assert_int_equal(furrow_checkpoint(loop.world), FURROW_OK);
	usage(furrow_mujoco_reset(loop.soil), "a checkpoint was made after");
	assert_int_equal(furrow_rollback(loop.world), FURROW_OK);
	assert_true(furrow_time(loop.world) > 0.19);
	furrow_mujoco_close(loop.soil);
	assert_int_equal(furrow_world_close(loop.world), FURROW_OK);
	end(&loop);
}

static void a_closed_soil_leaves_the_world(void **state)
{
	furrow_body foot;
	(void)state;
	struct loop loop = begin("closed.furrow");
	go(&loop, 50);
	assert_int_equal(furrow_checkpoint(loop.world), FURROW_OK);
	furrow_mujoco_close(loop.soil);
	assert_int_equal(furrow_body_find(loop.world, "mujoco.foot", &foot), FURROW_INPUT);
	assert_int_equal(furrow_step(loop.world, 0.01), FURROW_OK);
	/* A rollback brings the body back; its mesh is still there. */
	assert_int_equal(furrow_rollback(loop.world), FURROW_OK);
	assert_int_equal(furrow_body_find(loop.world, "mujoco.foot", &foot), FURROW_OK);
	assert_int_equal(furrow_step(loop.world, 0.01), FURROW_OK);
	assert_int_equal(furrow_body_remove(loop.world, foot), FURROW_OK);
	/* One that is refused leaves nothing: its second geom has a name that is taken. */
	assert_int_equal(open_soil(&loop), FURROW_OK);
	mjModel *model = engine_model("<mujoco><worldbody><body pos=\"0 0 1\"><joint type=\"slide\" axis=\"0 0 1\"/><geom name=\"heel\" size=\"0.2\"/>"
				      "<geom name=\"foot\" size=\"0.2\" pos=\"0 1 0\"/></body></worldbody></mujoco>");
	assert_non_null(model);
	struct loop refused = {.world = loop.world, .model = model, .data = engine.mj_makeData(model)};
	assert_int_equal(open_soil(&refused), FURROW_INPUT);
	assert_non_null(strstr(furrow_last_error(), "mujoco.foot"));
	assert_int_equal(furrow_body_find(loop.world, "mujoco.heel", &foot), FURROW_INPUT);
	end(&refused);
	furrow_mujoco_close(loop.soil);
	/* A second one for the same model. */
	assert_int_equal(open_soil(&loop), FURROW_OK);
	go(&loop, 50);
	/* The world goes first. */
	assert_int_equal(furrow_world_close(loop.world), FURROW_OK);
	usage(furrow_mujoco_touch(loop.soil, loop.data), "world");
	usage(furrow_mujoco_reset(loop.soil), "world");
	furrow_mujoco_close(loop.soil);
	end(&loop);
}

TEST_PROGRAM(loops)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_foot_stands_in_a_loop_of_c),
		cmocka_unit_test(named_arrays_are_enough),
		cmocka_unit_test(what_is_no_step_is_refused),
		cmocka_unit_test(a_reset_goes_to_its_own_checkpoint_alone),
		cmocka_unit_test(a_closed_soil_leaves_the_world),
	};
	return cmocka_run_group_tests(tests, engine_enter, support_leave);
}
