/* The model `slippage` over whole sweeps: nothing is lost, whatever the ground, the object and the windows. */
#include "conserve.h"
#include "../support/program.h"

static void every_quantum_stays(void **state)
{
	(void)state;
	need_gpu();
	conserve_every_quantum(DEFORM_SLIPPAGE);
}

TEST_PROGRAM(slippage)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(every_quantum_stays),
	};
	return cmocka_run_group_tests_name("deform/slippage", tests, open_gpu, close_gpu);
}
