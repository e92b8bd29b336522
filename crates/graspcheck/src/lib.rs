//! Plan, prove, simulate, record and judge grasp motions of robot arms.
