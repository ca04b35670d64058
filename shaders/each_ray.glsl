// SPDX-License-Identifier: Apache-2.0
// Unrolls loops over the sub-rays of a footprint: EACH_RAY(M) is M(0) M(1) ... M(RAYS - 1). The results of a sub-ray
// then stay in registers even where the compiler does not unroll long loops: with real loops, footprints of 19 sub-rays
// took 2.7 times as long on lavapipe. LOOPED_RAYS asks for real loops, for a compiler that cannot cope with so much code;
// CUDA has them for more than 19 sub-rays.
#define RAYS_TO_2(M) M(1)
#define RAYS_TO_7(M) M(2) M(3) M(4) M(5) M(6)
#define RAYS_TO_19(M) M(7) M(8) M(9) M(10) M(11) M(12) M(13) M(14) M(15) M(16) M(17) M(18)
#define RAYS_TO_61(M)                                                                                                 \
  M(19) M(20) M(21) M(22) M(23) M(24) M(25) M(26) M(27) M(28) M(29) M(30) M(31) M(32) M(33) M(34) M(35) M(36) M(37) \
  M(38) M(39) M(40) M(41) M(42) M(43) M(44) M(45) M(46) M(47) M(48) M(49) M(50) M(51) M(52) M(53) M(54) M(55) M(56) \
  M(57) M(58) M(59) M(60)
#ifndef EACH_RAY
#ifdef LOOPED_RAYS
#define EACH_RAY(M) [[dont_unroll]] for (uint ray = 0; ray < RAYS; ++ray) { M(ray) }
#else
#define EACH_RAY(M)                 \
  M(0)                              \
  if (RAYS > 1) { RAYS_TO_2(M) }    \
  if (RAYS > 2) { RAYS_TO_7(M) }    \
  if (RAYS > 7) { RAYS_TO_19(M) }   \
  if (RAYS > 19) { RAYS_TO_61(M) }
#endif
#endif
